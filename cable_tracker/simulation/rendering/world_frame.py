"""The turn between the world of the renderer and that of the vehicle: a quarter about the vertical.

The vehicle's world has x along the general course of the cable and y to its left, see `vehicle`.
The renderer's has x across to the right and y along, and counts a raised nose as positive. Axes are
exchanged and signs changed, so that nothing is rounded.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray


def from_renderer(vectors: FloatArray) -> FloatArray:
    """Return vectors of the renderer's world in the vehicle's, shape (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((y, -x, z), axis=-1)


def to_renderer(vectors: FloatArray) -> FloatArray:
    """Return vectors of the vehicle's world in the renderer's, shape (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((-y, x, z), axis=-1)


def angles_from_renderer(angles: FloatArray) -> FloatArray:
    """Return the renderer's yaw, pitch, roll as roll, pitch, yaw of REP 103, shape (..., 3) [rad].

    Yaw counts from the course in both.
    """
    yaw, pitch, roll = np.moveaxis(angles, -1, 0)
    return np.stack((roll, -pitch, yaw), axis=-1)


def angles_to_renderer(angles: FloatArray) -> FloatArray:
    """Return roll, pitch, yaw of REP 103 as yaw, pitch, roll of the renderer, (..., 3) [rad]."""
    roll, pitch, yaw = np.moveaxis(angles, -1, 0)
    return np.stack((yaw, -pitch, roll), axis=-1)
