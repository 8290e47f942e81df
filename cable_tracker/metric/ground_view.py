"""A camera over the plane of a cable, and the projection of image points onto that plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.calibration import CameraModel
from cable_tracker.metric.frames import Attitude, Mounting


@dataclass(frozen=True, slots=True)
class GroundView:
    """A camera over the plane of the cable.

    Attributes
    ----------
    camera : CameraModel
        The camera.
    mounting : Mounting
        On the vehicle.
    attitude : Attitude
        Attitude of the vehicle.
    height : float
        Height of base_link above the cable's axis [m].
    height_sigma : float
        Standard deviation of the height [m].
    """

    camera: CameraModel
    mounting: Mounting
    attitude: Attitude
    height: float
    height_sigma: float

    @property
    def clearance(self) -> float:
        """Height of the camera over the cable [m]; not above 0: it sees no ground."""
        return float(self.height + (self.attitude.rotation @ self.mounting.position)[2])

    def ground_to_image(self) -> FloatArray:
        """Return the homography from the ground, seen from above, to the image, shape (3, 3).

        The ground from above, at the cable's height, is an image frame in metres: x to the right, y
        ahead, in the level frame. The third number that a point gets is its depth before the
        camera.
        """
        level = self.attitude.rotation
        centre = level @ self.mounting.position
        ground = np.array(
            [[0.0, 1.0, -centre[0]], [-1.0, 0.0, -centre[1]], [0.0, 0.0, -self.clearance]]
        )
        mapping: FloatArray = self.camera.image_matrix @ (level @ self.mounting.rotation).T @ ground
        return mapping

    def on_ground(self, points: FloatArray) -> FloatArray:
        """Return where points of the image (N, 2) [px] lie at the cable's height, (N, 2) [m].

        In the level frame; the lens counts as a pinhole. NaN at and above the horizon, and where
        the camera is no higher than the cable.
        """
        if self.clearance <= 0.0:
            return np.full((len(points), 2), np.nan)
        to_ground = np.linalg.inv(self.ground_to_image())
        places = np.column_stack((points, np.ones(len(points)))) @ to_ground.T
        # What lies behind the camera, or nowhere, has a depth that is not positive.
        with np.errstate(divide="ignore", invalid="ignore"):
            right, ahead = np.where(places[:, 2:] > 0.0, places[:, :2] / places[:, 2:], np.nan).T
        return np.column_stack((ahead, -right))
