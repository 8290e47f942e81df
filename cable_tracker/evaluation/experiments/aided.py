"""The tracker with a simulated vehicle's odometry, sound or broken, as a `Method`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from operator import itemgetter

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.evaluation.experiments.simulated_vehicle import (
    SimulatedVehicle,
    TimedMessage,
    odometry_message,
    simulated_vehicle,
)
from cable_tracker.metric.cable_instrument_fusion import CableInstrumentFusion
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.trackers import make_tracker

FAULT_AFTER = 1.0
"""Time after the first twist at which faults begin [s]."""

LATENESS = 0.5
"""Delay of late twists, and error of wrong stamps [s]."""

WRONG_SCALE = 1.3
"""Factor on all velocities, when it is wrong."""


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
