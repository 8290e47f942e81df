"""Camera poses from which a cable has a given state in the image.

The two borders are two planes through the camera. They meet in a line parallel to the cable, the
angle between them determines the distance of the cable, and the roll of the vehicle the vertical:
(d, alpha, w, beta) and the roll fix the pose of the camera over a straight cable but for its
position along it.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import project_borders, states_in_chart
from cable_tracker.cable.model.state import ANGLE, STATE_SIZE
from cable_tracker.simulation.borders import fit_states, project_tube
from cable_tracker.simulation.rendering.camera import Camera, CameraPoses, chain
from cable_tracker.simulation.rendering.tube import Tube

CORRECTIONS = 3
"""Number of corrections of the poses for the bends of the cable and the camera's distortion."""

FARTHEST_VIEW = 4.0
"""The cable's direction is taken at the image centre, up to this many altitudes ahead."""


def steer(
    tube: Tube, camera: Camera, states: FloatArray, roll: FloatArray, travel: FloatArray
) -> CameraPoses:
    """Return the poses from which a cable has given states in the image.

    Parameters
    ----------
    states : FloatArray
        d, alpha, w, beta wanted, shape (N, 4) or (N, 8) [px, rad]; |alpha| below about 80 deg.
    roll : FloatArray
        Roll of the image, right side down, shape (N,) [rad].
    travel : FloatArray
        Position of the camera along the cable, shape (N,) [m].
    """
    wanted = np.zeros((states.shape[0], STATE_SIZE))
    wanted[:, :4] = states[:, :4]
    command = wanted.copy()
    poses = _steer_straight(tube, camera, command, roll, travel)
    if tube.bends or camera.is_distorted:
        for _ in range(CORRECTIONS):
            actual = fit_states(project_tube(tube, camera, poses), camera.image_size)
            command += wanted - _in_chart_of(wanted, actual)
            poses = _steer_straight(tube, camera, command, roll, travel)
    return poses


def _in_chart_of(wanted: FloatArray, actual: FloatArray) -> FloatArray:
    """Return actual states written about the angles of the wanted ones, shape (N, 8)."""
    shifted = actual.copy()
    shifted[:, ANGLE] -= wanted[:, ANGLE]
    chart = states_in_chart(shifted, 0.0)
    chart[:, ANGLE] += wanted[:, ANGLE]
    return chart


def _steer_straight(
    tube: Tube, camera: Camera, states: FloatArray, roll: FloatArray, travel: FloatArray
) -> CameraPoses:
    """Return the poses over a straight cable: the tangent of the tube at the image centre."""
    forward, sideways, towards, distance = _cable_from_camera(camera, states, tube.radius)
    up = _vertical(sideways, towards, roll)
    ahead = distance * np.clip(forward[:, 2] / towards[:, 2], -FARTHEST_VIEW, FARTHEST_VIEW)
    points, directions = tube.axis(travel + ahead)
    world_up = np.zeros_like(up)
    world_up[:, 2] = 1.0
    in_world = np.stack((directions, world_up, np.cross(directions, world_up)), axis=2)
    in_camera = np.stack((forward, up, np.cross(forward, up)), axis=1)
    rotations = chain(in_world, in_camera)
    sin, cos = np.sin(tube.heading), np.cos(tube.heading)
    back = ahead / (directions[:, 1] * cos - directions[:, 0] * sin)
    foot = points - back[:, None] * directions
    to_axis = np.einsum("nij,nj->ni", rotations, towards)
    return CameraPoses(foot - distance[:, None] * to_axis, rotations)


def _cable_from_camera(
    camera: Camera, states: FloatArray, radius: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the axis of a straight cable in the camera frame, from its borders in the image.

    Unit vectors along it, to its right and from the camera to it, shape (N, 3) each; and its
    distance, shape (N,) [m].
    """
    borders = project_borders(states)
    normals = np.stack(
        (
            camera.focal * np.cos(borders.angles),
            camera.focal * np.sin(borders.angles),
            borders.offsets,
        ),
        axis=-1,
    )
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    left, right = normals[:, 0], normals[:, 1]
    forward = np.cross(right, left)
    forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
    sideways = left + right
    sideways /= np.linalg.norm(sideways, axis=-1, keepdims=True)
    distance = 2 * radius / np.linalg.norm(right - left, axis=-1)
    return forward, sideways, np.cross(forward, sideways), distance


def _vertical(sideways: FloatArray, towards: FloatArray, roll: FloatArray) -> FloatArray:
    """Return the world's vertical in the camera frame, (N, 3): normal to the cable, at a roll."""
    first, second = -towards[:, 0], sideways[:, 0]
    share = np.clip(-np.sin(roll) / np.hypot(first, second), -1.0, 1.0)
    turn = np.arctan2(second, first) - np.arccos(share)
    up: FloatArray = np.sin(turn)[:, None] * sideways - np.cos(turn)[:, None] * towards
    return up
