"""How the camera has moved: where the pixels of the frame before are now."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.target.model.state import PoseColumn

STEP = 1.0
"""Length over which the local turn and stretch of a homography are measured [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraMotion:
    """A homography between frames; of a turning camera it holds at all distances.

    Attributes
    ----------
    homography : FloatArray
        Takes points of the frame before to those of this one, shape (3, 3); origin at the image
        centre, y up [px of the frame].
    """

    homography: FloatArray

    def moved(self, states: FloatArray, zoom: float) -> FloatArray:
        """Return poses (N, 6) in pixels of the working image, `zoom` of the frame's, carried on."""
        places = states[:, :2] * zoom
        here = self._mapped(places)
        ahead = self._mapped(places + np.array([STEP, 0.0])) - here
        moved = states.copy()
        moved[:, :2] = here / zoom
        moved[:, PoseColumn.ANGLE] += np.arctan2(ahead[:, 1], ahead[:, 0])
        moved[:, PoseColumn.LOG_SCALE] += np.log(np.maximum(np.hypot(*ahead.T) / STEP, 1e-3))
        return moved

    def _mapped(self, points: FloatArray) -> FloatArray:
        homogeneous = np.column_stack((points, np.ones(len(points)))) @ self.homography.T
        mapped: FloatArray = homogeneous[:, :2] / homogeneous[:, 2:]
        return mapped
