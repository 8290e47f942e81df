"""Vehicle states and readings of the instruments on a dive whose camera poses are prescribed."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.frames import rotations_of
from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.dive import Dive
from cable_tracker.simulation.instruments.instrument_writer import FIX_SIGMA, Tick
from cable_tracker.simulation.instruments.instruments import (
    USUAL_ERRORS,
    InstrumentErrors,
    InstrumentSet,
)
from cable_tracker.simulation.rendering.camera import from_renderer
from cable_tracker.simulation.vehicle import VehicleState

READING_RATE = 50.0
"""Approximate rate of the readings of odometry and imu [1/s]."""

MOST_READINGS = 200
"""Largest number of readings of each instrument between two frames."""

READINGS_AT_ONCE = 64
"""Readings of each instrument for which the geometry is computed at once."""

DIFFERENCE_STEP = 2e-3
"""Half the time over which velocities are taken [s]."""


def dive_ticks(
    frames: Iterable[Frame | None],
    dive: Dive,
    rate: float,
    seed: int,
    errors: InstrumentErrors = USUAL_ERRORS,
) -> Iterator[Tick]:
    """Yield the readings of the instruments with each frame of a dive, and until the next one.

    The altimeter is read with each frame; a fix comes with the first frame in each second.

    Parameters
    ----------
    frames : iterable of Frame or None
        Frames of the dive, from its beginning; None for one that is not drawn.
    rate : float
        Frames per second.
    seed : int
        Not negative; draws the errors of the instruments.
    errors : InstrumentErrors
        Standard deviations of their errors.
    """
    readings = int(np.clip(round(READING_RATE / rate), 1, MOST_READINGS))
    rng = np.random.default_rng([seed, 30])
    start = vehicle_states_at(dive, np.zeros(1))[0]
    instruments = InstrumentSet(errors, start, rng)
    for count, (frame, states) in enumerate(
        zip(frames, _states(dive, rate, readings), strict=False)
    ):
        for number, (time, state) in enumerate(states):
            fix = altitude = None
            if number == 0:
                if count == 0 or int(count / rate) > int((count - 1) / rate):
                    fix = state.position[:2] + FIX_SIGMA * rng.standard_normal(2)
                altitude = instruments.altitude(state)
            # Odometry counts the time since the reading before.
            elapsed = 1.0 / (rate * readings) if count or number else 0.0
            odometry, imu = instruments.odometry(state, elapsed), instruments.imu(state)
            picture = None if number else frame
            yield Tick(time, state, odometry, imu, altitude, fix, picture)


def _states(dive: Dive, rate: float, readings: int) -> Iterator[list[tuple[float, VehicleState]]]:
    """Yield the times [s] and vehicle states of the readings from each frame to the next."""
    parts = np.arange(readings) / readings
    # Worked out for several frames at once, which takes a fraction of the time.
    batch = max(1, READINGS_AT_ONCE // readings)
    for start in itertools.count(0, batch):
        times = (np.arange(start, start + batch)[:, None] + parts).ravel() / rate
        states = list(zip(times.tolist(), vehicle_states_at(dive, times), strict=True))
        for first in range(0, len(states), readings):
            yield states[first : first + readings]


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
