"""Which hypothesis of a frame continues which one of the frame before."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.weigh.presence import PriorPresence
from cable_tracker.cable.model.geometry import relative_direction
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.compilation import compiled_inside, compiled_loop

SAME_HYPOTHESIS_RADII = np.array([14.0, 0.2, 14.0, 0.2])
"""Largest differences of d, alpha, w, beta between a hypothesis and the expected one of the frame
before that it continues [px at the reference width, rad]."""


@compiled_loop
def inherited_log_odds(prior: PriorPresence, mean: FloatArray, radii: FloatArray) -> float:
    """Return the log-odds that a hypothesis inherits; NaN for a new one.

    Parameters
    ----------
    prior : PriorPresence
        The hypotheses of the frame before.
    mean : FloatArray
        The hypothesis, shape (8,).
    radii : FloatArray
        `SAME_HYPOTHESIS_RADII` for frames of this size, shape (4,) [px, rad].
    """
    inherited, least = math.nan, 1.0
    for index in range(len(prior.log_odds)):
        distance = scaled_pose_distance(mean, prior.expected[index], radii)
        if distance < least:
            inherited, least = prior.log_odds[index], distance
    return inherited


@compiled_inside
def is_same_hypothesis(mean: FloatArray, expected: FloatArray, radii: FloatArray) -> bool:
    """Tell whether a hypothesis continues an expected one, shapes (8,), `radii` (4,) [px, rad]."""
    return bool(scaled_pose_distance(mean, expected, radii) < 1.0)


@compiled_inside
def scaled_pose_distance(state: FloatArray, expected: FloatArray, radii: FloatArray) -> float:
    """Return the largest difference of d, alpha, w, beta in units of `radii` (4,) [px, rad].

    The state is taken in the chart about the angle of the expected one, shapes (8,).
    """
    wrapped, sign = relative_direction(state[ANGLE], expected[ANGLE])
    beside = max(
        abs(sign * state[DISTANCE] - expected[DISTANCE]) / radii[DISTANCE],
        abs(state[WIDTH] - expected[WIDTH]) / radii[WIDTH],
    )
    turned = max(
        abs(wrapped) / radii[ANGLE], abs(sign * state[SKEW] - expected[SKEW]) / radii[SKEW]
    )
    return float(max(beside, turned))
