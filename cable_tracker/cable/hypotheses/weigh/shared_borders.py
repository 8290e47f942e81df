"""Whether two strips have a border in common."""

from __future__ import annotations

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import border_offset, relative_direction, wrap_angle
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.compilation import compiled_inside, compiled_loop

SHARED_OFFSET, SHARED_ANGLE = 8.0, 0.12
"""Largest distance and angle between two borders that may be the same one [px at the reference
width, rad]."""


@compiled_loop
def is_within_shared_border_limits(strip: FloatArray, mean: FloatArray, unit: float) -> bool:
    """Tell whether any border of a strip is within both limits of any border of a hypothesis.

    Distances are between the crossings d -+ w/2 with the centrelines' normals. `strip` and `mean`
    have shape (8,), `unit` is that of `shared_border_score`.
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


@compiled_inside
def shared_border_score(
    state: FloatArray, angle: float, offset: float, side: float, unit: float
) -> tuple[int, float]:
    """Return which border of a strip may be a given border, and the score that it is.

    Parameters
    ----------
    state : FloatArray
        The strip, shape (8,).
    angle, offset : float
        The given border in Hesse normal form [rad, px].
    side : float
        Border of the strip that is compared, with the strip's normal turned to within pi/2 of
        `angle`: -1 left, 1 right.
    unit : float
        Pixels of the frame per pixel at the reference width.

    Returns
    -------
    (int, float)
        Index of that border as the state is written, 0 left, 1 right; product of the parabolic
        windows of distance and angle, 1 for the same line, 0 from `SHARED_OFFSET` or
        `SHARED_ANGLE` on.
    """
    _, sign = relative_direction(state[ANGLE], angle)
    own = sign * side
    its_offset = sign * border_offset(state[DISTANCE], state[WIDTH], state[SKEW], own)
    apart = (its_offset - offset) / (SHARED_OFFSET * unit)
    turn = wrap_angle(state[ANGLE] - angle + own * state[SKEW]) / SHARED_ANGLE
    return (1 if own > 0.0 else 0), parabolic_window(apart) * parabolic_window(turn)


@compiled_inside
def parabolic_window(distance: float) -> float:
    """Return max(1 - distance**2, 0)."""
    return max(1.0 - distance * distance, 0.0)
