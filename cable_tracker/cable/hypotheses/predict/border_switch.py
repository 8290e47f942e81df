"""The other border of a cable may be another one: the density of border switches.

A hypothesis often holds one border of the cable and takes a furrow, a shadow or another cable's
border for the other one. So the cable may be, with a small probability in each frame, any strip
that shares a border with the hypothesis that leads, on either side of it: a border switch.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.predict.frame_noise import FrameNoise
from cable_tracker.cable.model.geometry import border_side
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    SKEW,
    WIDTH,
)
from cable_tracker.compilation import compiled_inside, compiled_loop

BORDER_SWITCH_RATE = 0.7
"""Rate at which a hypothesis turns out to have one border wrong [1/s]."""

OFFSET_SIGMA, ANGLE_SIGMA, SKEW_SIGMA = 4.0, math.radians(2.0), math.radians(6.0)
"""How exactly the shared border is known [px at the reference width, rad], and how far the skew is
from that of the hypothesis [rad]."""

COMBINATIONS = 4
"""The left or the right border of the hypothesis is the left or the right one of the strip."""


class BorderSwitch(NamedTuple):
    """Density of strips that share a border with a hypothesis.

    Attributes
    ----------
    crossings : FloatArray
        d -+ w/2: where the left and right border cross the centreline's normal through its foot
        point [px], shape (2,).
    angles : FloatArray
        alpha -+ beta: normal angles of the left and right border [rad], shape (2,).
    skew : float
        beta of the hypothesis [rad].
    narrowest, widest : float
        Limits of the widths of the strips, the first one below the other [px].
    offset_sigma : float
        `OFFSET_SIGMA` for frames of this size [px].
    """

    crossings: FloatArray
    angles: FloatArray
    skew: float
    narrowest: float
    widest: float
    offset_sigma: float


def switch_from(
    leader: FloatArray, narrowest: float, widest: float, frame_scale: float
) -> BorderSwitch:
    """Return the density of border switches from a hypothesis, shape (4 or more,), in its chart.

    `frame_scale`: see `WorkingImage`.
    """
    distance, angle, width, skew = leader[:POSE_SIZE].tolist()
    return BorderSwitch(
        np.array([distance - 0.5 * width, distance + 0.5 * width]),
        np.array([angle - skew, angle + skew]),
        skew,
        narrowest,
        widest,
        OFFSET_SIGMA * frame_scale,
    )


@compiled_loop
def place_switches(
    states: FloatArray, start: int, stop: int, switch: BorderSwitch, noise: FrameNoise
) -> None:
    """Draw the poses of strips into the rows from `start` to `stop`."""
    for row in range(start, stop):
        combination = (row - start) % COMBINATIONS
        shared, side = combination // 2, border_side(combination % 2)
        offset = switch.crossings[shared] + switch.offset_sigma * noise.normal[row, DISTANCE]
        angle = switch.angles[shared] + ANGLE_SIGMA * noise.normal[row, ANGLE]
        ratio = switch.widest / switch.narrowest
        width = switch.narrowest * math.pow(ratio, noise.uniform[row, WIDTH])
        skew = switch.skew + SKEW_SIGMA * noise.normal[row, SKEW]
        states[row, DISTANCE] = offset - 0.5 * side * width
        states[row, ANGLE] = angle - side * skew
        states[row, WIDTH] = width
        states[row, SKEW] = skew


@compiled_inside
def switch_density(state: FloatArray, switch: BorderSwitch) -> float:
    """Return the density of border switches at d, alpha, w, beta of a state."""
    width = state[WIDTH]
    if not switch.narrowest <= width <= switch.widest:
        return 0.0
    total = 0.0
    turn = (state[SKEW] - switch.skew) / SKEW_SIGMA
    for combination in range(COMBINATIONS):
        shared, side = combination // 2, border_side(combination % 2)
        a = (state[DISTANCE] + 0.5 * side * width - switch.crossings[shared]) / switch.offset_sigma
        b = (state[ANGLE] + side * state[SKEW] - switch.angles[shared]) / ANGLE_SIGMA
        squared = a * a + b * b + turn * turn
        if squared < 50.0:
            total += math.exp(-0.5 * squared)
    scales = switch.offset_sigma * ANGLE_SIGMA * SKEW_SIGMA * math.pow(2.0 * math.pi, 1.5)
    log_range = math.log(switch.widest / switch.narrowest)
    return float(total / (COMBINATIONS * scales * width * log_range))
