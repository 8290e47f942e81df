"""Motion of the camera between two frames, as a homography."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.target.model.state import ANGLE, LOG_SCALE

STEP = 1.0
"""Length over which the local turn and stretch of a homography are measured [px]."""

LEAST_DEPTH = 0.3
"""Least depth of the corners before the turned camera, against that of the picture's centre, at
which the homography is used."""


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

    def keeps_picture(self, image_size: tuple[int, int]) -> bool:
        """Return whether all points of a picture stay well in front of the camera.

        After a farther turn a homography is useless: towards the camera's side all lengths grow
        without bounds, and points behind it are mirrored.

        Parameters
        ----------
        image_size : (int, int)
            Width and height of the frame [px].
        """
        right, up = (side / 2 for side in image_size)
        corners = np.array([[x, y, 1.0] for x in (-right, right) for y in (-up, up)])
        centre = self.homography[2, 2]
        is_mirrored = np.linalg.det(self.homography) * centre <= 0.0
        depths = corners @ self.homography[2] * centre
        return bool(not is_mirrored and (depths >= LEAST_DEPTH * centre**2).all())

    def moved(self, states: FloatArray, zoom: float) -> FloatArray:
        """Return poses (N, 6) mapped into this frame; `zoom` of its pixels are one of a pose."""
        places = states[:, :2] * zoom
        here = self._mapped(places)
        ahead = self._mapped(places + np.array([STEP, 0.0])) - here
        moved = states.copy()
        moved[:, :2] = here / zoom
        moved[:, ANGLE] += np.arctan2(ahead[:, 1], ahead[:, 0])
        moved[:, LOG_SCALE] += np.log(np.maximum(np.hypot(*ahead.T) / STEP, 1e-3))
        return moved

    def _mapped(self, points: FloatArray) -> FloatArray:
        homogeneous = np.column_stack((points, np.ones(len(points)))) @ self.homography.T
        centre = self.homography[2, 2]
        # Poses far beyond the picture, which turn behind the camera, stay on their side of it.
        depths = centre * np.maximum(homogeneous[:, 2:] / centre, LEAST_DEPTH)
        mapped: FloatArray = homogeneous[:, :2] / depths
        return mapped


def usable_motion(motion: CameraMotion | None, image_size: tuple[int, int]) -> CameraMotion | None:
    """Return a motion, or None if it is unknown or does not keep the picture.

    Parameters
    ----------
    motion : CameraMotion or None
        Motion of the camera since the frame before, where it is known.
    image_size : (int, int)
        Width and height of the frame [px].
    """
    return motion if motion is not None and motion.keeps_picture(image_size) else None
