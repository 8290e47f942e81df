"""Vehicle of a simulated scenario: its poses, instrument messages and ground truth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.frames import Attitude
from cable_tracker.metric.instruments import Instruments
from cable_tracker.metric.odometry.motion import TWIST
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.simulation.dive import Dive
from cable_tracker.simulation.instruments.instruments import (
    LEAST_RANGE,
    MOST_RANGE,
    InstrumentErrors,
    scale_error,
)
from cable_tracker.simulation.motion.flight import Flight, flight_at, twists_at
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.scenarios.catalogue import find_scenario
from cable_tracker.simulation.scenarios.scenario import SCENARIO_RATE
from cable_tracker.simulation.scenarios.scenario_dive import SCENARIO_SIZE, scenario_dive
from cable_tracker.stamps import stamp_at
from cable_tracker.tracking.image_frame import image_centre

ODOMETRY_RATE = 50.0
"""Twists per second."""

LOOK_AHEAD = 0.5
"""Distance for the offset ahead of the vehicle [m]."""

TRUTH_REACH, TRUTH_STEP = 3.0, 0.02
"""Length to both sides of the vehicle over which the cable is followed, and step between the points
[m]."""


EXPERIMENT_ERRORS = InstrumentErrors(turn_bias=math.radians(0.1), velocity_scale=0.01)
"""How wrong the instruments are in experiments: worse than in the simulator's dives."""


def cables_below(dive: Dive, flight: Flight) -> FloatArray:
    """Return the true offset at x = 0, offset ahead, and heading, shape (N, 3) [m, rad].

    In the level frame of each instant. The heading is that of the cable where the camera looks.
    """
    reach = np.arange(-TRUTH_REACH, TRUTH_REACH, TRUTH_STEP)
    truths = []
    for position, angles in zip(flight.positions, flight.angles, strict=True):
        points, _ = dive.tube.axis(position[1] + reach)
        yaw = angles[2]
        relative = points[:, :2] - position[:2]
        ahead = relative @ [-math.sin(yaw), math.cos(yaw)]
        left = relative @ [-math.cos(yaw), -math.sin(yaw)]
        order = np.argsort(ahead)
        seen = position[2] * math.tan(dive.camera.mounting)
        places = np.array([0.0, LOOK_AHEAD, seen - 0.1, seen + 0.1])
        foot, far, near, beyond = np.interp(places, ahead[order], left[order])
        truths.append((foot, far, math.atan2(beyond - near, 0.2)))
    return np.array(truths)


def calibration_of(camera: Camera) -> Calibration:
    """Return the calibration of a simulated camera."""
    return Calibration(
        camera.image_size,
        "plumb_bob",
        (camera.focal, camera.focal),
        image_centre(camera.image_size),
        camera.distortion if camera.is_distorted else (),
    )


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedVehicle:
    """The instruments of a scenario's vehicle, with everything that they say during the dive.

    Attributes
    ----------
    truths : FloatArray
        Offset at x = 0, offset ahead, heading in each frame, shape (N, 3) [m, rad].
    altitudes : FloatArray
        True ones in each frame, shape (N,) [m].
    instruments : Instruments
        Calibration, altitude, attitude.
    twists : FloatArray
        Measured twists, shape (M, 6), at `twist_stamps` [ns].
    twist_stamps : list of int
        Length M.
    covariance : FloatArray
        Covariance that odometry states of its twists, shape (6, 6).
    """

    truths: FloatArray
    altitudes: FloatArray
    instruments: Instruments
    twists: FloatArray
    twist_stamps: list[int]
    covariance: FloatArray


def simulated_vehicle(scenario: str, seed: int, errors: InstrumentErrors) -> SimulatedVehicle:
    """Return the vehicle of a scenario; the same seed gives the same errors of its instruments."""
    rng = np.random.default_rng([seed, 20])
    dive = scenario_dive(scenario, seed, SCENARIO_SIZE)
    count = find_scenario(scenario).frame_count
    frame_times = np.arange(count) / SCENARIO_RATE
    flight = flight_at(dive, frame_times)
    twist_times = np.arange(0.0, frame_times[-1] + 1e-9, 1.0 / ODOMETRY_RATE)
    twists, covariance = _disturbed(twists_at(dive, twist_times), errors, rng)
    return SimulatedVehicle(
        truths=cables_below(dive, flight),
        altitudes=flight.positions[:, 2],
        instruments=_instruments(dive, flight, errors, rng),
        twists=twists,
        twist_stamps=[stamp_at(time) for time in twist_times],
        covariance=covariance,
    )


def _disturbed(
    twists: FloatArray, errors: InstrumentErrors, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    steps = np.repeat([errors.velocity, errors.turn], 3)
    biases = np.repeat([errors.velocity_bias, errors.turn_bias], 3)
    scale = scale_error(errors, rng)
    wrong = twists + biases * rng.standard_normal(TWIST)
    wrong += steps * rng.standard_normal(twists.shape)
    wrong[:, :3] *= scale
    return wrong, np.diag(steps**2 + biases**2)


def _instruments(
    dive: Dive, flight: Flight, errors: InstrumentErrors, rng: np.random.Generator
) -> Instruments:
    instruments = Instruments(
        CableVehicleParameters(
            camera_pitch=90.0 - math.degrees(dive.camera.mounting),
            look_ahead=LOOK_AHEAD,
            cable_height=dive.tube.height,
            altitude_is_vertical=True,
            altitude_sigma=errors.altitude,
        )
    )
    instruments.take_calibration(calibration_of(dive.camera))
    for time, position, angles in zip(flight.times, flight.positions, flight.angles, strict=True):
        altitude = float(position[2]) * (1.0 + errors.altitude * float(rng.standard_normal()))
        roll, pitch = angles[:2] + errors.attitude * rng.standard_normal(2)
        stamp = stamp_at(float(time))
        instruments.take_altitude(stamp, altitude, (LEAST_RANGE, MOST_RANGE))
        instruments.take_attitude(stamp, Attitude(float(roll), float(pitch), errors.attitude))
    return instruments
