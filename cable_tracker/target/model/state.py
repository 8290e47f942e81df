"""The pose of a target.

Image coordinates: origin at the image centre, x right, y up, pixels of the working image; angles
counter-clockwise. The angle and the scale are those against the template.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from cable_tracker.arrays import FloatArray


class PoseColumn(IntEnum):
    """Columns of an array of poses."""

    X = 0
    Y = 1
    LOG_SCALE = 2
    ANGLE = 3
    X_RATE = 4
    Y_RATE = 5


POSE_SIZE = 4
"""Columns of the pose: position, scale and angle."""

X, Y, LOG_SCALE, ANGLE = range(POSE_SIZE)
"""Their columns for kernels."""

STATE_SIZE = len(PoseColumn)
"""Those of the pose, and the rates of the position, per second."""

UNKNOWN_COVARIANCE: FloatArray = np.eye(STATE_SIZE) * 1e6
"""Covariance of a pose of which nothing is known; estimates share it, so it cannot be written."""
UNKNOWN_COVARIANCE.setflags(write=False)


def in_frame_pixels(states: FloatArray, zoom: float) -> FloatArray:
    """Return poses, shape (N, 6), with lengths in pixels of the frame; `zoom` of those a pixel."""
    scaled = states.copy()
    for column in (PoseColumn.X, PoseColumn.Y, PoseColumn.X_RATE, PoseColumn.Y_RATE):
        scaled[:, column] *= zoom
    return scaled


def wrap_full_turn(angles: FloatArray) -> FloatArray:
    """Return angles in (-pi, pi]."""
    wrapped: FloatArray = -np.remainder(np.pi - angles, 2.0 * np.pi) + np.pi
    return wrapped


def distances_from(x: float, y: float, states: FloatArray) -> FloatArray:
    """Return how far from a place poses (N, 4 or 6) are, shape (N,) [px]."""
    distances: FloatArray = np.hypot(states[:, PoseColumn.X] - x, states[:, PoseColumn.Y] - y)
    return distances


def at_rest(poses: FloatArray) -> FloatArray:
    """Return poses (N, 4) with rates of zero, shape (N, 6)."""
    states = np.zeros((len(poses), STATE_SIZE))
    states[:, :POSE_SIZE] = poses
    return states
