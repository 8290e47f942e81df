"""Whether two strips have a border in common."""

from __future__ import annotations

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import border_offset, turn_sign, wrapped_angle
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH
from cable_tracker.compilation import compiled_inside, compiled_loop

SHARED_OFFSET, SHARED_ANGLE = 8.0, 0.12
"""Borders that are nearer than this are one [px at the reference width, rad]."""


@compiled_loop
def shares_border(strip: FloatArray, mean: FloatArray, image_width: float) -> bool:
    """Tell whether a border of a strip lies on one of a hypothesis."""
    shifted = strip[ANGLE] - mean[ANGLE]
    wrapped = wrapped_angle(shifted)
    sign = turn_sign(shifted, wrapped)
    offset, angle, skew = sign * strip[DISTANCE], wrapped + mean[ANGLE], sign * strip[SKEW]
    nearest = SHARED_OFFSET * image_width / REFERENCE_WIDTH
    for side in (-1.0, 1.0):
        for other in (-1.0, 1.0):
            own, its = offset + 0.5 * side * strip[WIDTH], 0.5 * other * mean[WIDTH]
            apart = own - mean[DISTANCE] - its
            turn = angle + side * skew - mean[ANGLE] - other * mean[SKEW]
            if abs(apart) < nearest and abs(turn) < SHARED_ANGLE:
                return True
    return False


@compiled_inside
def closeness_to_border(
    state: FloatArray, angle: float, offset: float, side: float, unit: float
) -> tuple[int, float]:
    """Return which border of a strip may be a given one, and how close they are, from 1 down to 0.

    Parameters
    ----------
    state : FloatArray
        The strip, shape (8,).
    angle, offset : float
        Normal of the given border [rad], and its distance from the image centre [px].
    side : float
        On which side of the strip it would lie, in the chart about it: -1 left, 1 right.
    unit : float
        Pixels of the frame per pixel at the reference width.
    """
    shifted = state[ANGLE] - angle
    sign = turn_sign(shifted, wrapped_angle(shifted))
    own = sign * side
    its_offset = sign * border_offset(state[DISTANCE], state[WIDTH], state[SKEW], own)
    apart = (its_offset - offset) / (SHARED_OFFSET * unit)
    turn = wrapped_angle(shifted + own * state[SKEW]) / SHARED_ANGLE
    return (1 if own > 0.0 else 0), falling(apart) * falling(turn)


@compiled_inside
def falling(distance: float) -> float:
    """Return 1 for no distance, down to 0 for 1 and more, of either sign."""
    return max(1.0 - distance * distance, 0.0)
