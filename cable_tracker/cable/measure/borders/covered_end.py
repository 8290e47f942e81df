"""Cables one end of which is covered: they go into the sand, or end.

Beyond the place where a cable goes under, the points of its borders say that there is none. From
one end on stretches are left out, at a cost, if together they speak against the cable by more than
that: without the cost, any short edge would be a cable. A third of what is in view has to be left.

Both ends were tried, too, as of a cable that only shows in the middle of the picture: on the worlds
to tune on less was found.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Float32Array
from cable_tracker.compilation import compiled_inside, compiled_loop

LEAST_SHOWN, SHOWN_PART = 3, 3
"""Stretches that are left at least; and one in so many of those in view."""


@compiled_loop
def leave_out_covered_end(
    stretches: Float32Array, column: int, cost: float, sums: Float32Array
) -> int:
    """Take the stretches of a covered end out of the sums, and return them; 0 if there is none.

    Bit k of what is returned is stretch k.

    Parameters
    ----------
    stretches : Float32Array
        Sums of both borders, not tempered, shape (2, 8, S) [nats]; 0 where no border is in view.
    column : int
        Polarity and class of strength that are looked at.
    cost : float
        What it costs that an end is covered, not tempered [nats].
    sums : Float32Array
        Those along each border, shape (2, 8).
    """
    most = _most_covered(stretches, column)
    from_first, ratio = _covered_from(stretches, column, 1, most, np.float32(-cost))
    from_last, _ = _covered_from(stretches, column, -1, most, ratio)
    # The last ones are covered only if they speak against the cable by more than the first ones.
    step, covered = (-1, from_last) if from_last else (1, from_first)
    if covered == 0:
        return 0
    for border in range(2):
        for number in range(covered):
            sums[border, column] -= stretches[border, column, _nth(number, step)]
        sums[border, column] -= np.float32(0.5 * cost)
    first_ones: int = (1 << covered) - 1
    return first_ones if step == 1 else first_ones << (stretches.shape[2] - covered)


@compiled_loop
def _covered_from(
    stretches: Float32Array, column: int, step: int, most: int, least: np.float32
) -> tuple[int, np.float32]:
    """Return how many stretches from one end on are covered, and their sum [nats].

    That speaks against the cable by the most, and is below `least`; else none are, and `least` is
    returned. `step`: 1 from the first stretch on, -1 from the last. `most`: how many of those in
    view may be.
    """
    covered, seen, total = 0, 0, np.float32(0.0)
    for number in range(stretches.shape[2]):
        both = _of_both_borders(stretches, column, _nth(number, step))
        seen += 1 if both != np.float32(0.0) else 0
        if seen > most:
            break
        total += both
        if total < least:
            covered, least = number + 1, total
    return covered, least


@compiled_loop
def _most_covered(stretches: Float32Array, column: int) -> int:
    """Return how many of the stretches in view may be covered."""
    in_view = 0
    for stretch in range(stretches.shape[2]):
        both = _of_both_borders(stretches, column, stretch)
        in_view += 1 if both != np.float32(0.0) else 0
    return in_view - max((in_view + SHOWN_PART - 1) // SHOWN_PART, LEAST_SHOWN)


@compiled_inside
def _of_both_borders(stretches: Float32Array, column: int, stretch: int) -> np.float32:
    """Return the sum of both borders in a stretch [nats]."""
    both: np.float32 = stretches[0, column, stretch] + stretches[1, column, stretch]
    return both


@compiled_inside
def _nth(number: int, step: int) -> int:
    """Return the index of the n-th stretch from the first on, or from the last for a step of -1.

    From behind it is negative, as in Python.
    """
    return number if step == 1 else -1 - number
