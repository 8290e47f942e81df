"""The pose of a target.

Image coordinates: origin at the image centre, x right, y up, pixels of the working image; angles
counter-clockwise. The angle and the scale are those against the template.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray

X, Y, LOG_SCALE, ANGLE, X_RATE, Y_RATE = range(6)
"""Columns of an array of poses: position, scale, angle, rates of the position [per second]."""

POSE_SIZE, STATE_SIZE = 4, 6
"""Columns of the pose, and of the pose with the rates."""

UNKNOWN_COVARIANCE: FloatArray = np.eye(STATE_SIZE) * 1e6
"""Covariance of a pose of which nothing is known; estimates share it, so it cannot be written."""
UNKNOWN_COVARIANCE.setflags(write=False)


def state_units(zoom: float) -> FloatArray:
    """Return factors that bring poses to lengths in pixels of the frame, shape (6,).

    `zoom` of those are one of the working image; angle and log scale stay as they are.
    """
    return np.array([zoom, zoom, 1.0, 1.0, zoom, zoom])


def wrap_full_turn(angles: FloatArray) -> FloatArray:
    """Return angles in (-pi, pi]."""
    wrapped: FloatArray = -np.remainder(np.pi - angles, 2.0 * np.pi) + np.pi
    return wrapped


def distances_from(x: float, y: float, states: FloatArray) -> FloatArray:
    """Return the distances of poses (N, 4 or 6) from a point, shape (N,) [px]."""
    distances: FloatArray = np.hypot(states[:, X] - x, states[:, Y] - y)
    return distances


def at_rest(poses: FloatArray) -> FloatArray:
    """Return poses (N, 4) with rates of zero, shape (N, 6)."""
    states = np.zeros((len(poses), STATE_SIZE))
    states[:, :POSE_SIZE] = poses
    return states
