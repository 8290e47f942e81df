"""The turn between the world of the renderer and that of the vehicle: a quarter about the vertical.

The vehicle's world has x along the general course of the cable and y to its left, see `vehicle`.
The renderer's has x across to the right and y along. Axes are exchanged and signs changed, so that
nothing is rounded.
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
