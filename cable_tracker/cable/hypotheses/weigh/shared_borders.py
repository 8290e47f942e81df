"""Whether two strips have a border in common."""

from __future__ import annotations

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import relative_direction
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.compilation import compiled_loop

SHARED_OFFSET, SHARED_ANGLE = 8.0, 0.12
"""Largest distance and angle between two borders that may be the same one [px at the reference
width, rad]."""


@compiled_loop
def is_within_shared_border_limits(strip: FloatArray, mean: FloatArray, unit: float) -> bool:
    """Tell whether any border of a strip is within both limits of any border of a hypothesis.

    Distances are between the crossings d -+ w/2 with the centrelines' normals. `strip` and `mean`
    have shape (8,); `unit`: pixels of the frame per pixel at the reference width.
    """
    wrapped, sign = relative_direction(strip[ANGLE], mean[ANGLE])
    offset, angle, skew = sign * strip[DISTANCE], wrapped + mean[ANGLE], sign * strip[SKEW]
    nearest = SHARED_OFFSET * unit
    for side in (-1.0, 1.0):
        for other in (-1.0, 1.0):
            own, its = offset + 0.5 * side * strip[WIDTH], 0.5 * other * mean[WIDTH]
            apart = own - mean[DISTANCE] - its
            turn = angle + side * skew - mean[ANGLE] - other * mean[SKEW]
            if abs(apart) < nearest and abs(turn) < SHARED_ANGLE:
                return True
    return False
