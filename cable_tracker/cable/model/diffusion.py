"""What the components of a state gain in variance between two frames."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.parameters.parameters import (
    REFERENCE_RATE,
    REFERENCE_WIDTH,
    TrackerParameters,
)

ALMOST_UNDAMPED = 1e-3
"""Logarithm of the damping over a gap, below which the sums of its powers are rounded away."""


def variances_per_frame(
    parameters: TrackerParameters, image_width: int
) -> tuple[FloatArray, FloatArray]:
    """Return the variances that pose and rates gain in a reference frame, (4,) each [px², rad²]."""
    pixel = (image_width / REFERENCE_WIDTH) ** 2
    radian = np.deg2rad(1.0) ** 2
    pose = np.array(
        [
            parameters.distance_variance * pixel,
            parameters.angle_variance * radian,
            parameters.width_variance * pixel,
            parameters.skew_variance * radian,
        ]
    )
    rates = np.array(
        [
            parameters.distance_rate_variance * pixel,
            parameters.angle_rate_variance * radian,
            parameters.width_rate_variance * pixel,
            parameters.skew_rate_variance * radian,
        ]
    )
    return pose, rates


def variances_over(
    per_frame: tuple[FloatArray, FloatArray], parameters: TrackerParameters, dt: float
) -> FloatArray:
    """Return the variance that each component gains in `dt` seconds, shape (8,) [px², rad², per s].

    The thesis gives variances per frame, see `variances_per_frame`, and rates per frame: a rate per
    second is 25 times as large, its variance 625 times. Over a longer gap the changes of the rates
    within it move the cable too, so that the prior widens as it would have done frame by frame.
    """
    pose, rates = per_frame
    frames = dt * REFERENCE_RATE
    carried = _carried_by_rates(frames, parameters.rate_damping)
    kept = _kept_by_rates(frames, parameters.rate_damping)
    return np.concatenate((pose * frames + rates * carried, rates * kept * REFERENCE_RATE**2))


def _kept_by_rates(frames: float, damping: float) -> float:
    """Return the variance of a damped rate after some frames, in units of that of one frame."""
    if damping == 1.0 or frames == 0.0:
        return frames
    log_damping = math.log(damping) if damping > 0.0 else -math.inf
    return math.expm1(2 * frames * log_damping) / math.expm1(2 * log_damping)


def _carried_by_rates(frames: float, damping: float) -> float:
    """Return the variance of the pose from rates that changed after the first of some frames.

    The sum of ((1 - a^k) / (1 - a))^2 over k from 1 to frames - 1, k^2 without damping, in a form
    that also holds between whole frames.
    """
    later = max(frames - 1.0, 0.0)
    if damping == 0.0:
        return later
    decay = -math.log(damping)
    if decay * later < ALMOST_UNDAMPED:
        return later * (later + 1.0) * (2.0 * later + 1.0) / 6.0
    once, twice = (
        math.exp(-power * decay) * math.expm1(-power * decay * later) / math.expm1(-power * decay)
        for power in (1, 2)
    )
    return (later - 2.0 * once + twice) / (1.0 - damping) ** 2
