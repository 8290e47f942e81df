"""The borders of a cable in the image, and the camera poses from which it has given states there.

The two borders are two planes through the camera. They meet in a line parallel to the cable, the
angle between them determines the distance of the cable, and the roll of the vehicle the vertical:
(d, alpha, w, beta) and the roll fix the pose of the camera over a straight cable but for its
position along it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.geometry import (
    Borders,
    project_borders,
    states_from_borders,
    states_in_chart,
    wrap_states,
)
from cable_tracker.cable.model.state import ANGLE, STATE_SIZE
from cable_tracker.simulation.rendering.camera import Camera, CameraPoses, chain
from cable_tracker.simulation.rendering.laid_cable import Tube
from cable_tracker.tracking.parameter_table import pixel_scale

POINT_COUNT = 261
"""Points along each border, at equal angles as seen from above the cable."""

WIDEST_ANGLE = np.deg2rad(86.0)
"""Largest angle from the vertical up to which the borders are followed, to the front and to the
back [rad]."""

FADE = 8.0
"""Points outside the image count less and less, with this decay [px at a width of 320]."""

CORRECTIONS = 3
"""Number of corrections of the poses for the bends of the cable and the camera's distortion."""

FARTHEST_VIEW = 4.0
"""The cable's direction is taken at the image centre, up to this many altitudes ahead."""


@dataclass(frozen=True, slots=True, eq=False)
class ProjectedBorders:
    """Both borders of a cable in N images, as chains of K points from back to front.

    Attributes
    ----------
    along : FloatArray
        Position along the cable's course, shape (N, K) [m].
    world : FloatArray
        Shape (N, 2, K, 3) [m]: left border, right border.
    points : FloatArray
        x, y in the image frame, shape (N, 2, K, 2) [px]; NaN behind the camera.
    lengths : FloatArray
        Length of border that each point stands for, shape (N, 2, K) [px].
    inside : BoolArray
        Whether the point lies inside the image, shape (N, 2, K).
    """

    along: FloatArray
    world: FloatArray
    points: FloatArray
    lengths: FloatArray
    inside: BoolArray

    def in_view(self) -> BoolArray:
        """Return in which images any part of a border lies, a mask of shape (N,)."""
        return np.asarray(self.inside.any(axis=(1, 2)))


def project_tube(tube: Tube, camera: Camera, poses: CameraPoses) -> ProjectedBorders:
    """Project the silhouette of a cable into the images of a camera."""
    angles = np.linspace(-WIDEST_ANGLE, WIDEST_ANGLE, POINT_COUNT)
    relative = poses.positions[:, :2] - np.array(tube.origin)
    cos, sin = np.cos(tube.heading), np.sin(tube.heading)
    below = relative[:, 1] * cos - relative[:, 0] * sin
    along = below[:, None] + poses.positions[:, 2, None] * np.tan(angles)
    world = tube.silhouette(poses.positions, along)
    points = camera.project(poses.to_camera(world))
    steps = np.linalg.norm(np.diff(points, axis=2), axis=-1)
    steps = np.where(np.isfinite(steps), steps, 0.0)
    lengths = np.zeros(points.shape[:3])
    lengths[..., 1:] += steps / 2
    lengths[..., :-1] += steps / 2
    limits = (np.array(camera.image_size) - 1) / 2
    with np.errstate(invalid="ignore"):
        inside = np.asarray((np.abs(points) <= limits).all(axis=-1))
    return ProjectedBorders(along, world, points, lengths, inside)


def fit_states(projected: ProjectedBorders, image_size: tuple[int, int]) -> FloatArray:
    """Fit a straight line to each border inside the image.

    A border that only passes near the image is fitted where it is nearest. Straight borders are
    exact in any case.

    Returns
    -------
    FloatArray
        d, alpha, w, beta and zeros for their rates, shape (N, 8), alpha in (-pi/2, pi/2]; NaN where
        the cable is out of view altogether.
    """
    width, height = image_size
    usable = np.isfinite(projected.points).all(axis=-1) & (projected.lengths > 0)
    points = np.where(usable[..., None], projected.points, 0.0)
    beyond = np.maximum(np.abs(points) - (np.array((width, height)) - 1) / 2, 0.0)
    outside = np.where(usable, np.hypot(beyond[..., 0], beyond[..., 1]), np.inf)
    nearest = outside.min(axis=-1, keepdims=True)
    lost = ~np.isfinite(nearest).all(axis=(1, 2))
    nearest = np.where(np.isfinite(nearest), nearest, 0.0)
    fade = FADE * pixel_scale(width)
    weights = np.where(usable, projected.lengths, 0.0) * np.exp(-(outside - nearest) / fade)
    states = np.zeros((points.shape[0], STATE_SIZE))
    states[:, :4] = states_from_borders(_fit_lines(points, weights))
    states[lost] = np.nan
    states[~lost] = wrap_states(states[~lost])
    return states


def _fit_lines(points: FloatArray, weights: FloatArray) -> Borders:
    """Fit lines (N, 2) to weighted points (N, 2, K, 2), normals to the right going forward."""
    total = np.maximum(weights.sum(axis=-1), 1e-300)
    middle = np.einsum("nbk,nbkc->nbc", weights, points) / total[..., None]
    offset = points - middle[:, :, None, :]
    x, y = offset[..., 0], offset[..., 1]
    xx, yy, xy = ((weights * product).sum(axis=-1) for product in (x * x, y * y, x * y))
    direction = np.arctan2(2 * xy, xx - yy) / 2
    cos, sin = np.cos(direction), np.sin(direction)
    place = np.arange(points.shape[2])
    mean_place = (weights * place).sum(axis=-1, keepdims=True) / total[..., None]
    forward = (weights * (place - mean_place) * (x * cos[..., None] + y * sin[..., None])).sum(-1)
    normal = direction - np.where(forward < 0, -np.pi / 2, np.pi / 2)
    normal[:, 1] = normal[:, 0] + np.mod(normal[:, 1] - normal[:, 0] + np.pi, 2 * np.pi) - np.pi
    rho = middle[..., 0] * np.cos(normal) + middle[..., 1] * np.sin(normal)
    return Borders(normal, rho)


def visible_share(projected: ProjectedBorders, index: int, hidden: BoolArray) -> float:
    """Return the share of the borders inside image `index` that nothing hides, 0 to 1.

    Parameters
    ----------
    hidden : BoolArray
        Whether points of the two borders are covered, shape (2, K).
    """
    lengths = np.where(projected.inside[index], projected.lengths[index], 0.0)
    total = float(lengths.sum())
    return float(lengths[~hidden].sum()) / total if total > 0 else 0.0


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
