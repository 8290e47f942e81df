"""The cable that a seed lays, and what of it a camera on a vehicle sees.

The world frame is that of `vehicle`: x along the general course of the cable, y to its left. The
renderer's has x across to the right and y along.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.state import CableState
from cable_tracker.simulation.borders import ProjectedBorders, fit_states, visible_share
from cable_tracker.simulation.camera import Camera, CameraPoses, VehiclePoses
from cable_tracker.simulation.dive import CABLE_RADIUS, Seeds
from cable_tracker.simulation.tube import Tube, random_bends
from cable_tracker.simulation.vehicle import VehicleState

CURVATURE = 0.04
"""The cable never bends more than this [1/m]."""

BEND_LENGTHS = (24.0, 45.0)
"""Shortest and longest bend of the cable [m]."""

NEAREST_STEPS = 6
"""Steps to the nearest point of the cable."""


def bent_cable(rng: np.random.Generator) -> Tube:
    """Draw a cable."""
    return Tube(CABLE_RADIUS, random_bends(CURVATURE, BEND_LENGTHS, 2, rng))


def cable_of_seed(seed: int) -> Tube:
    """Return the cable that a seed draws."""
    return bent_cable(np.random.default_rng(Seeds.of(seed).course))


def cable_points(tube: Tube, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points and directions of a cable in the world, each (N, 3), at places (N,) [m]."""
    points, directions = tube.axis(along)
    return _from_renderer(points), _from_renderer(directions)


def nearest_along(tube: Tube, place: FloatArray, along: float) -> float:
    """Return where along a cable the point nearest to a place (2,) is; `along` is a guess [m]."""
    for _ in range(NEAREST_STEPS):
        points, directions = cable_points(tube, np.array([along]))
        way = float((place - points[0, :2]) @ directions[0, :2])
        along += way * float(directions[0, 0])
    return along


def camera_poses(camera: Camera, motion: VehicleState) -> CameraPoses:
    """Return the pose of a vehicle's camera, one of them, as the renderer takes it."""
    roll, pitch, yaw = motion.angles
    x, y, z = motion.position
    # The renderer counts a raised nose as positive.
    poses = VehiclePoses(np.array([[-y, x, z]]), np.array([[yaw, -pitch, roll]]))
    return camera.poses(poses)


def seen_state(
    projected: ProjectedBorders, hidden: BoolArray, image_size: tuple[int, int]
) -> tuple[CableState | None, float]:
    """Return the cable in an image, and the share of its borders in it that nothing hides.

    None and 0 if nothing of it can be seen. `hidden` (2, K): which points something covers.
    """
    visibility = visible_share(projected, 0, hidden)
    if visibility <= 0.0:
        return None, 0.0
    return CableState.from_array(fit_states(projected, image_size)[0]), visibility


def _from_renderer(vectors: FloatArray) -> FloatArray:
    return np.stack((vectors[..., 1], -vectors[..., 0], vectors[..., 2]), axis=-1)
