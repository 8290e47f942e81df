"""Mean and covariance of cables, correct across the wrap of the angle.

(d, alpha) and (-d, alpha + pi) are one line, so directions are averaged on the double cover: the
angles are doubled, averaged as directions, and halved. In the chart about that mean direction, the
cables are averaged as vectors.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import states_in_chart, wrap_angles, wrapped_estimate
from cable_tracker.cable.model.state import ANGLE
from cable_tracker.particle_filter.particles import weighted_covariance, weighted_mean


def mean_line_angle(angles: FloatArray, weights: FloatArray) -> float:
    """Return the mean direction of lines [rad] in (-pi/2, pi/2]; shapes (N,), (N,)."""
    doubled = 2.0 * angles
    mean = 0.5 * np.arctan2(weights @ np.sin(doubled), weights @ np.cos(doubled))
    return float(wrap_angles(mean))


def cable_mean_and_covariance(
    states: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the MMSE estimate (8,) and the covariance (8, 8) of weighted cables (N, 8).

    The estimate's angle is in (-pi/2, pi/2], and the covariance is expressed for that way of
    writing the line. `weights` has shape (N,) and sums to one.
    """
    chart = states_in_chart(states, mean_line_angle(states[:, ANGLE], weights))
    mean = weighted_mean(chart, weights)
    covariance = weighted_covariance(chart, weights, mean)
    return wrapped_estimate(mean, covariance)
