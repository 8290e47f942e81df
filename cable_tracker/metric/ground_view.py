"""A camera over the plane of a cable: image points on that plane, and how it moves in the image.

Two images of a plane differ by a homography. The lens is taken as a pinhole here: over the motion
from one frame to the next, its distortion is nearly the same before and after.

References
----------
R. Hartley and A. Zisserman (2004), "Multiple View Geometry", section 13.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, mean_and_covariance, sigma_points
from cable_tracker.cable.model.geometry import Borders, project_borders, states_from_borders
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.metric.calibration import CameraModel
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.odometry.motion import PoseChange, rotations_by

LEAST_CLEARANCE = 0.1
"""Distance of the camera from the plane that is assumed at least [m]."""


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


def homography(view: GroundView, change: PoseChange) -> FloatArray:
    """Return the homography from points of the earlier image to the later one, shape (3, 3).

    For points of the image frame [px] that lie in the plane of the cable.
    """
    mapping: FloatArray = _homographies(
        view, change.rotation[None], change.translation[None], np.array([view.height])
    )[0]
    return mapping


def _homographies(
    view: GroundView, rotations: FloatArray, translations: FloatArray, heights: FloatArray
) -> FloatArray:
    """Return the homographies (N, 3, 3) of motions (N, 3, 3), (N, 3) at heights (N,)."""
    rotation, position = view.mounting.rotation, view.mounting.position
    turned = np.swapaxes(rotations, 1, 2)
    to_later = rotation.T @ turned @ rotation
    arms = np.einsum("nij,nj->ni", turned, position - translations) - position
    shifts = arms @ rotation
    level = view.attitude.rotation
    down = (level @ rotation).T @ np.array([0.0, 0.0, -1.0])
    clearances = np.maximum(heights + float((level @ position)[2]), LEAST_CLEARANCE)
    planes = to_later + shifts[:, :, None] * down / clearances[:, None, None]
    matrix = view.camera.image_matrix
    mapped: FloatArray = matrix @ planes @ np.linalg.inv(matrix)
    return mapped / mapped[:, 2:, 2:]


def move_states(states: FloatArray, mapping: FloatArray) -> FloatArray:
    """Return d, alpha, w, beta of cables (N, >= 4) after a homography, shape (N, 4).

    `mapping` is one for all of them, (3, 3), or one each, (N, 3, 3).

    The angle is that of the same normal, and may lie outside (-pi/2, pi/2].
    """
    borders = project_borders(states)
    lines = np.stack(
        (np.cos(borders.angles), np.sin(borders.angles), -borders.offsets), axis=-1
    ) @ np.linalg.inv(mapping)
    lines /= np.hypot(lines[..., 0], lines[..., 1])[..., None]
    turned = np.arctan2(lines[..., 1], lines[..., 0])
    # The normal turns by less than half a turn: its angle goes on from the one before.
    angles = borders.angles + np.mod(turned - borders.angles + np.pi, 2 * np.pi) - np.pi
    return states_from_borders(Borders(angles, -lines[..., 2]))


def prediction_covariance(state: FloatArray, view: GroundView, change: PoseChange) -> FloatArray:
    """Return the covariance that odometry and altitude give a predicted cable, shape (4, 4).

    Of d, alpha, w, beta [px, rad]. Sigma points of the pose change's covariance and of the height
    are carried through the homography.

    Parameters
    ----------
    state : FloatArray
        The cable before, shape (>= 4,).
    view, change
        See `homography`.
    """
    covariance = np.zeros((7, 7))
    covariance[:6, :6] = change.covariance
    covariance[6, 6] = view.height_sigma**2
    errors = sigma_points(np.zeros(7), covariance)
    turns = rotations_by(errors[:, 3:6])
    mappings = _homographies(
        view,
        change.rotation @ turns,
        change.translation + errors[:, :3],
        view.height + errors[:, 6],
    )
    moved = move_states(np.tile(state[:POSE_SIZE], (len(errors), 1)), mappings)
    return mean_and_covariance(moved)[1]


@dataclass(frozen=True, slots=True, eq=False)
class PlaneMotion:
    """A motion between two frames, as the filters take it (`cable.model.movement.MotionAid`).

    Attributes
    ----------
    mapping : FloatArray
        The homography, shape (3, 3).
    seconds : float
        Time between the frames.
    pose_sigmas : FloatArray
        Standard deviations of d, alpha, w, beta after the motion, shape (4,) [px, rad].
    """

    mapping: FloatArray
    seconds: float
    pose_sigmas: FloatArray

    def moved(self, states: FloatArray) -> FloatArray:
        """Return states (N, 8) after the motion."""
        after = np.empty((len(states), STATE_SIZE))
        after[:, :POSE_SIZE] = move_states(states, self.mapping)
        after[:, POSE_SIZE:] = (after[:, :POSE_SIZE] - states[:, :POSE_SIZE]) / self.seconds
        return after

    def scales(self) -> FloatArray:
        """Return the standard deviations of what is unknown, shape (8,)."""
        return np.concatenate((self.pose_sigmas, self.pose_sigmas / self.seconds))
