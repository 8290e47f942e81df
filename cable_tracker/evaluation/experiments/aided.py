"""A simulated vehicle with instruments and ground truth, and the tracker aided by its odometry.

That tracker is a `Method`; odometry is sound or broken.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache
from itertools import repeat
from operator import itemgetter

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.metric.cable_instrument_fusion import CableInstrumentFusion
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
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
from cable_tracker.stamps import FIRST_STAMP, NANOSECONDS, stamp_at
from cable_tracker.trackers import make_tracker

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

FAULT_AFTER = 1.0
"""Time after the first twist at which faults begin [s]."""

LATENESS = 0.5
"""Delay of late twists, and error of wrong stamps [s]."""

WRONG_SCALE = 1.3
"""Factor on all velocities, when it is wrong."""


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


class OdometryFault(str, Enum):
    """Fault of odometry."""

    NONE = "sound"
    FROZEN = "frozen"
    """Odometry that repeats its last twist."""

    HANGING = "hanging"
    """Odometry that repeats its last twist, with noise on it."""

    SILENT = "silent"
    """Odometry that stops."""

    LATE = "late"
    """Twists come late, with the right stamps."""

    WRONG_STAMPS = "wrong stamps"
    """Twists come in time, with stamps of another clock."""

    TURNED = "turned"
    """Odometry mounted the wrong way round: forward is backward, left is right."""

    SCALED = "scale wrong"
    """Odometry whose velocities are all too high by `WRONG_SCALE`."""


def faulty(
    stamps: list[int], twists: FloatArray, fault: OdometryFault, rng: np.random.Generator
) -> tuple[list[int], list[int], FloatArray]:
    """Return arrival times and stamps [ns], and twists (M, 6), of odometry with a fault."""
    begin = stamps[0] + round(FAULT_AFTER * NANOSECONDS)
    first = next((k for k, stamp in enumerate(stamps) if stamp >= begin), len(stamps))
    lateness = round(LATENESS * NANOSECONDS)
    arrivals, stated, values = list(stamps), list(stamps), twists.copy()
    if fault is OdometryFault.SILENT:
        return arrivals[:first], stated[:first], values[:first]
    if fault in (OdometryFault.FROZEN, OdometryFault.HANGING):
        values[first:] = values[min(first, len(values) - 1)]
        if fault is OdometryFault.HANGING:
            values[first:] += 1e-3 * rng.standard_normal(values[first:].shape)
    elif fault is OdometryFault.LATE:
        arrivals = [stamp + lateness for stamp in arrivals]
    elif fault is OdometryFault.WRONG_STAMPS:
        stated = [stamp + lateness for stamp in stated]
    elif fault is OdometryFault.TURNED:
        values[:, [0, 1, 3, 4]] *= -1.0
    elif fault is OdometryFault.SCALED:
        values *= WRONG_SCALE
    return arrivals, stated, values


class AidedMethod:
    """The tracker of this project, with the instruments of a vehicle, as a node receives them.

    Parameters
    ----------
    parameters : TrackerParameters
        All of them, also the seed.
    vehicle : SimulatedVehicle
        Vehicle whose instruments give the readings.
    fault : OdometryFault or None
        Fault of the odometry; None: there is no odometry.
    """

    def __init__(
        self, parameters: TrackerParameters, vehicle: SimulatedVehicle, fault: OdometryFault | None
    ) -> None:
        self._tracker = make_tracker(parameters)
        self._fusion = CableInstrumentFusion(vehicle.parameters)
        pending = [(message[0], message) for message in vehicle.messages]
        if fault is not None:
            rng = np.random.default_rng([parameters.seed, 21])
            pending += _odometry_messages(vehicle, fault, rng)
        # Taken from the end.
        self._pending = sorted(pending, key=itemgetter(0))[::-1]

    def initialise(self, given: GivenState) -> None:
        """Start from this cable at the next frame."""
        self._tracker.initialise(given)

    def process(self, image: Image, stamp: int) -> CableEstimate:
        """Take a frame into account, with the instruments' messages until then."""
        while self._pending and self._pending[-1][0] <= stamp:
            stated, instrument, message = self._pending.pop()[1]
            self._fusion.take_message(instrument, stated, message)
        motion = self._fusion.motion(stamp, image)
        estimate = self._tracker.process(image, stamp, motion)
        self._fusion.observe(estimate)
        return estimate

    def measure(self, estimate: CableEstimate) -> CrossTrack | Withheld:
        """Return the cable of an estimate in metres, or why not."""
        return self._fusion.measure(estimate)


def _odometry_messages(
    vehicle: SimulatedVehicle, fault: OdometryFault, rng: np.random.Generator
) -> list[tuple[int, TimedMessage]]:
    """Return the messages of odometry with a fault, each with its time of arrival [ns]."""
    twists = np.array([reading.twist for reading in vehicle.odometry])
    readings = zip(*faulty(vehicle.odometry_stamps, twists, fault, rng), strict=True)
    return [
        (
            arrival,
            (stamp, Instrument.ODOMETRY, odometry_message(stamp, replace(sound, twist=twist))),
        )
        for sound, (arrival, stamp, twist) in zip(vehicle.odometry, readings, strict=False)
    ]


@dataclass(frozen=True, slots=True)
class AidedFilter:
    """A filter with the instruments of a scenario's vehicle. It is sent to other processes.

    Attributes
    ----------
    name : str
        Name of the method in results.
    parameters : TrackerParameters
        All of them; the seed is that of the run.
    scenario : str
        Scenario of the vehicle.
    fault : OdometryFault or None
        Fault of the odometry; None: there is no odometry.
    """

    name: str
    parameters: TrackerParameters
    scenario: str
    fault: OdometryFault | None

    def make(self, seed: int) -> AidedMethod:
        """Make a fresh tracker for the dive of a seed."""
        parameters = self.parameters.replaced({"seed": seed})
        return AidedMethod(parameters, simulated_vehicle(self.scenario, seed), self.fault)
