"""Poses and velocities of the vehicle of a simulated dive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.frames import rotations_of
from cable_tracker.simulation.dive import Dive
from cable_tracker.simulation.motion.vehicle import VehicleState
from cable_tracker.simulation.rendering.world_frame import from_renderer

DIFFERENCE_STEP = 2e-3
"""Half the time over which velocities are taken [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class VehiclePoses:
    """Poses of a vehicle at N times; base_link is at the camera.

    Attributes
    ----------
    times : FloatArray
        Times since the first frame, shape (N,) [s].
    positions : FloatArray
        Positions in the world of the simulation, shape (N, 3) [m]; z is the altitude.
    angles : FloatArray
        Roll, pitch, yaw as REP 103 has them, yaw from the world's y, shape (N, 3) [rad].
    """

    times: FloatArray
    positions: FloatArray
    angles: FloatArray

    def rotations(self) -> FloatArray:
        """Return the rotations from base_link to the world, shape (N, 3, 3)."""
        quarter = np.array([0.0, 0.0, np.pi / 2])
        return rotations_of(self.angles + quarter)


def vehicle_poses_at(dive: Dive, times: FloatArray) -> VehiclePoses:
    """Return the poses of the vehicle of a dive at times (N,) [s]."""
    poses = dive.geometry(times).poses
    return VehiclePoses(times, poses.positions, dive.camera.vehicle_angles(poses))


def twists_at(dive: Dive, times: FloatArray) -> FloatArray:
    """Return the exact twists in base_link at times (N,) [s], shape (N, 6) [m/s, rad/s]."""
    before, after = (
        vehicle_poses_at(dive, times + step) for step in (-DIFFERENCE_STEP, DIFFERENCE_STEP)
    )
    now = vehicle_poses_at(dive, times).rotations()
    velocity = (after.positions - before.positions) / (2 * DIFFERENCE_STEP)
    change = np.einsum("nji,njk->nik", before.rotations(), after.rotations())
    turn = np.stack(
        (
            change[:, 2, 1] - change[:, 1, 2],
            change[:, 0, 2] - change[:, 2, 0],
            change[:, 1, 0] - change[:, 0, 1],
        ),
        axis=1,
    ) / (4 * DIFFERENCE_STEP)
    return np.hstack((np.einsum("nji,nj->ni", now, velocity), turn))


def vehicle_states_at(dive: Dive, times: FloatArray) -> list[VehicleState]:
    """Return the states of the vehicle at times (N,) [s].

    In the world of `vehicle`: x along the general course of the cable. Accelerations are not given.
    """
    poses, twists = vehicle_poses_at(dive, times), twists_at(dive, times)
    positions = from_renderer(poses.positions)
    nothing = np.zeros(3)
    return [
        VehicleState(position, angles, twist, nothing)
        for position, angles, twist in zip(positions, poses.angles, twists, strict=True)
    ]
