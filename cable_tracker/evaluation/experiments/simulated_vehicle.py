"""Vehicle of a simulated scenario: its poses, instrument messages and ground truth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import repeat

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.simulation.dive import Dive
from cable_tracker.simulation.instruments.dive_ticks import (
    VehiclePoses,
    dive_ticks,
    vehicle_poses_at,
)
from cable_tracker.simulation.instruments.instrument_messages import (
    ALTIMETER,
    BASE,
    CAMERA,
    ODOM,
    make_camera_info,
    make_imu,
    make_odometry,
    make_range,
)
from cable_tracker.simulation.instruments.instrument_writer import Tick
from cable_tracker.simulation.instruments.instruments import InstrumentErrors, OdometryReading
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.scenario_dive import SCENARIO_SIZE, scenario_dive
from cable_tracker.simulation.scenarios import SCENARIO_RATE, find_scenario
from cable_tracker.stamps import FIRST_STAMP, stamp_at

LOOK_AHEAD = 0.5
"""Distance for the offset ahead of the vehicle [m]."""

TRUTH_REACH, TRUTH_STEP = 3.0, 0.02
"""Length to both sides of the vehicle over which the cable is followed, and step between the points
[m]."""

FACTORY = RosbagsMessages()

TimedMessage = tuple[int, Instrument, Message]
"""Stamp of a message [ns], its instrument, and the message."""

EXPERIMENT_ERRORS = InstrumentErrors(turn_bias=math.radians(0.1), velocity_scale=0.01)
"""Errors of the instruments in experiments: larger than in the simulator's dives."""


def cables_below(dive: Dive, poses: VehiclePoses) -> FloatArray:
    """Return the true offset at x = 0, offset ahead, and heading, shape (N, 3) [m, rad].

    In the level frame of each instant. The heading is that of the cable where the camera looks.
    """
    reach = np.arange(-TRUTH_REACH, TRUTH_REACH, TRUTH_STEP)
    truths = []
    for position, angles in zip(poses.positions, poses.angles, strict=True):
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


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedVehicle:
    """Messages of the instruments of a scenario's vehicle during a dive, and the truth.

    Attributes
    ----------
    truths : FloatArray
        Offset at x = 0, offset ahead, heading in each frame, shape (N, 3) [m, rad].
    altitudes : FloatArray
        True altitudes in each frame, shape (N,) [m].
    parameters : CableVehicleParameters
        Mounting and errors of camera and instruments.
    messages : list of (int, Instrument, Message)
        Messages of all instruments but odometry, each with its stamp [ns].
    odometry : list of OdometryReading
        Readings of odometry, length M.
    odometry_stamps : list of int
        Stamps of these readings, length M [ns].
    """

    truths: FloatArray
    altitudes: FloatArray
    parameters: CableVehicleParameters
    messages: list[TimedMessage]
    odometry: list[OdometryReading]
    odometry_stamps: list[int]


@lru_cache(maxsize=2)
def simulated_vehicle(
    scenario: str, seed: int, errors: InstrumentErrors = EXPERIMENT_ERRORS
) -> SimulatedVehicle:
    """Return the vehicle of a scenario; the same seed gives the same errors of its instruments.

    Filters that are compared on one dive share it: it takes seconds to work out.
    """
    dive = scenario_dive(scenario, seed, SCENARIO_SIZE)
    count = find_scenario(scenario).frame_count
    ticks = list(dive_ticks(repeat(None, count), dive, SCENARIO_RATE, seed, errors))
    poses = vehicle_poses_at(dive, np.arange(count) / SCENARIO_RATE)
    return SimulatedVehicle(
        truths=cables_below(dive, poses),
        altitudes=poses.positions[:, 2],
        parameters=CableVehicleParameters(
            camera_pitch=90.0 - math.degrees(dive.camera.mounting),
            look_ahead=LOOK_AHEAD,
            cable_height=dive.tube.height,
            altitude_is_vertical=True,
            altitude_sigma=errors.altitude,
        ),
        messages=list(_messages(ticks, dive.camera, errors)),
        odometry=[tick.odometry for tick in ticks],
        odometry_stamps=[stamp_at(tick.seconds) for tick in ticks],
    )


def _messages(
    ticks: Iterable[Tick], camera: Camera, errors: InstrumentErrors
) -> Iterator[TimedMessage]:
    at_camera = make_header(FACTORY, FIRST_STAMP, CAMERA)
    calibration = make_camera_info(FACTORY, at_camera, camera)
    yield FIRST_STAMP, Instrument.CAMERA_INFO, calibration
    for tick in ticks:
        stamp = stamp_at(tick.seconds)
        at_base = make_header(FACTORY, stamp, BASE)
        yield stamp, Instrument.IMU, make_imu(FACTORY, at_base, tick.imu, errors)
        if tick.altitude is not None:
            at_altimeter = make_header(FACTORY, stamp, ALTIMETER)
            yield stamp, Instrument.ALTITUDE, make_range(FACTORY, at_altimeter, tick.altitude)


def odometry_message(stamp: int, reading: OdometryReading) -> Message:
    """Pack a reading of odometry with a stamp [ns]."""
    return make_odometry(FACTORY, make_header(FACTORY, stamp, ODOM), reading)
