"""See `cable_tracker.cable.model.geometry`."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled, compiled_fast, compiled_inside

TWO_OVER_PI = 2.0 / np.pi
HALF_PI = np.pi / 2


@compiled_inside
def wrapped_angle(angle: float) -> float:
    """Wrap the angle of a normal to (-pi/2, pi/2]."""
    # Without the remainder of a division, which takes longer than all the rest.
    wrapped: float = angle - math.pi * np.rint(angle / math.pi)
    if wrapped <= -math.pi / 2:
        return wrapped + math.pi
    return wrapped - math.pi if wrapped > math.pi / 2 else wrapped


@compiled_inside
def turn_sign(angle: float, wrapped: float) -> float:
    """Return -1 if an odd number of half turns lies between two ways of writing it, else 1."""
    turns = 0.5 * np.rint((angle - wrapped) / math.pi)
    return 1.0 if turns == np.floor(turns) else -1.0


@compiled_inside
def unwrap_state(state: FloatArray, reference_angle: float, result: FloatArray) -> None:
    """Fill in the way to write a cable (8,) whose normal is within pi/2 of an angle [rad]."""
    angle = state[1] - reference_angle
    wrapped = wrapped_angle(angle)
    sign = turn_sign(angle, wrapped)
    result[0] = sign * state[0]
    result[1] = wrapped + reference_angle
    result[2] = state[2]
    result[3] = sign * state[3]
    result[4] = sign * state[4]
    result[5] = state[5]
    result[6] = state[6]
    result[7] = sign * state[7]


@compiled
def unwrap_states(states: FloatArray, reference_angle: float) -> FloatArray:
    """Write cables (N, 8) with their normal angle within pi/2 of a reference angle [rad]."""
    result = np.empty_like(states)
    for row in range(len(states)):
        unwrap_state(states[row], reference_angle, result[row])
    return result


@compiled
def wrap_states(states: FloatArray) -> FloatArray:
    """Write cables (N, 8) with their normal angle in (-pi/2, pi/2]."""
    return unwrap_states(states, 0.0)


@compiled_fast
def sine_and_cosine(angle: float) -> tuple[float, float]:
    """Return both, exact to 1e-15 within a few turns.

    By series without branches, so that the processor does several angles at a time.
    """
    quarter = np.floor(angle * TWO_OVER_PI + 0.5)
    a = angle - quarter * HALF_PI
    b = a * a
    sine = a * (
        1.0
        + b * (-1 / 6
        + b * (1 / 120
        + b * (-1 / 5040
        + b * (1 / 362880
        + b * (-1 / 39916800
        + b * (1 / 6227020800
        + b * (-1 / 1307674368000)))))))
    )  # fmt: skip
    cosine = (
        1.0
        + b * (-1 / 2
        + b * (1 / 24
        + b * (-1 / 720
        + b * (1 / 40320
        + b * (-1 / 3628800
        + b * (1 / 479001600
        + b * (-1 / 87178291200
        + b * (1 / 20922789888000))))))))
    )  # fmt: skip
    turned = quarter - 4.0 * np.floor(quarter * 0.25)
    odd = turned == 1.0 or turned == 3.0
    first = cosine if odd else sine
    second = sine if odd else cosine
    return (
        -first if turned == 2.0 or turned == 3.0 else first,
        -second if turned == 1.0 or turned == 2.0 else second,
    )
