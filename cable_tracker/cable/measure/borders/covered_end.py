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
from cable_tracker.compilation import compiled_loop

LEAST_SHOWN, SHOWN_PART = 3, 3
"""Stretches that are left at least; and one in so many of those in view."""

MOST_UNSEEN = 0.4
"""Share of the stretches in view without which a cable is looked at, at most. If more is covered,
it may be a bar that ends: of 33 pictures of real ground with one on it, swayed over, 0.4 % of the
frames are claimed, with half in place of this share 14 %."""


@compiled_loop
def leave_out_covered_end(stretches: Float32Array, cost: float, sums: Float32Array) -> int:
    """Take the stretches of a covered end out of the sums, if there is one.

    Returned is without which the cable is to be looked at: bit k is stretch k; 0 if there is no
    covered end, or more of what is in view is covered than `MOST_UNSEEN`.

    Parameters
    ----------
    stretches : Float32Array
        Sums of both borders for one polarity and class of strength, not tempered, shape (2, S)
        [nats]; 0 where no border is in view.
    cost : float
        What it costs that an end is covered, not tempered [nats].
    sums : Float32Array
        Those along each border, shape (2,).
    """
    from_last = stretches[:, ::-1]
    in_view = _in_view(stretches)
    most = in_view - max((in_view + SHOWN_PART - 1) // SHOWN_PART, LEAST_SHOWN)
    first_ones, ratio = _first_covered(stretches, most, np.float32(-cost))
    last_ones, _ = _first_covered(from_last, most, ratio)
    # The last ones are covered only if they speak against the cable by more than the first ones.
    end, covered = (from_last, last_ones) if last_ones else (stretches, first_ones)
    if covered == 0:
        return 0
    for border in range(2):
        for stretch in range(covered):
            sums[border] -= end[border, stretch]
        sums[border] -= np.float32(0.5 * cost)
    if _in_view(end[:, :covered]) > MOST_UNSEEN * in_view:
        return 0
    ones: int = (1 << covered) - 1
    return ones << (stretches.shape[1] - covered) if last_ones else ones


@compiled_loop
def _in_view(stretches: Float32Array) -> int:
    """Return how many of the stretches are in view."""
    in_view = 0
    for stretch in range(stretches.shape[1]):
        both = stretches[0, stretch] + stretches[1, stretch]
        in_view += 1 if both != np.float32(0.0) else 0
    return in_view


@compiled_loop
def _first_covered(stretches: Float32Array, most: int, least: np.float32) -> tuple[int, np.float32]:
    """Return how many stretches from the first on are covered, and their sum [nats].

    That speaks against the cable by the most, and is below `least`; else none are, and `least` is
    returned. `most`: how many of those in view may be.
    """
    covered, seen, total = 0, 0, np.float32(0.0)
    for stretch in range(stretches.shape[1]):
        both = stretches[0, stretch] + stretches[1, stretch]
        seen += 1 if both != np.float32(0.0) else 0
        if seen > most:
            break
        total += both
        if total < least:
            covered, least = stretch + 1, total
    return covered, least
