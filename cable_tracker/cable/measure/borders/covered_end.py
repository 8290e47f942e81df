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

LEAST_SHOWN = 3
"""Stretches that are left at least, and the part of those in view: a third."""


@compiled_loop
def leave_out_covered_end(
    stretches: Float32Array, column: int, cost: float, sums: Float32Array
) -> None:
    """Take the stretches of a covered end out of the sums, if there is one.

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
    count = stretches.shape[2]
    in_view = 0
    for stretch in range(count):
        both = stretches[0, column, stretch] + stretches[1, column, stretch]
        in_view += 1 if both != np.float32(0.0) else 0
    most = in_view - max((in_view + LEAST_SHOWN - 1) // LEAST_SHOWN, LEAST_SHOWN)
    least, step, covered = np.float32(-cost), 0, 0
    for direction in (1, -1):
        first = 0 if direction == 1 else count - 1
        total, seen = np.float32(0.0), 0
        for number in range(count):
            stretch = first + direction * number
            both = stretches[0, column, stretch] + stretches[1, column, stretch]
            seen += 1 if both != np.float32(0.0) else 0
            if seen > most:
                break
            total += both
            if total < least:
                least, step, covered = total, direction, number + 1
    first = 0 if step == 1 else count - 1
    for number in range(covered):
        for border in range(2):
            sums[border, column] -= stretches[border, column, first + step * number]
    if covered:
        for border in range(2):
            sums[border, column] -= np.float32(0.5 * cost)
