"""The tracker with a simulated vehicle's odometry, sound or broken, as a `Method`."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.evaluation.experiments.simulated_vehicle import (
    EXPERIMENT_ERRORS,
    SimulatedVehicle,
    simulated_vehicle,
)
from cable_tracker.evaluation.methods import Method
from cable_tracker.metric.odometry.aiding import MotionAiding
from cable_tracker.metric.odometry.motion import Odometry
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
    arrivals, said, values = list(stamps), list(stamps), twists.copy()
    if fault is OdometryFault.SILENT:
        return arrivals[:first], said[:first], values[:first]
    if fault in (OdometryFault.FROZEN, OdometryFault.HANGING):
        values[first:] = values[min(first, len(values) - 1)]
        if fault is OdometryFault.HANGING:
            values[first:] += 1e-3 * rng.standard_normal(values[first:].shape)
    elif fault is OdometryFault.LATE:
        arrivals = [stamp + lateness for stamp in arrivals]
    elif fault is OdometryFault.WRONG_STAMPS:
        said = [stamp + lateness for stamp in said]
    elif fault is OdometryFault.TURNED:
        values[:, [0, 1, 3, 4]] *= -1.0
    elif fault is OdometryFault.SCALED:
        values *= WRONG_SCALE
    return arrivals, said, values


class AidedMethod:
    """The tracker of this project, told the vehicle's motion.

    Parameters
    ----------
    parameters : TrackerParameters
        All of them, also the seed.
    vehicle : SimulatedVehicle
        Whose odometry it hears.
    """

    def __init__(
        self, parameters: TrackerParameters, vehicle: SimulatedVehicle, fault: OdometryFault
    ) -> None:
        self._tracker = make_tracker(parameters)
        self._odometry = Odometry()
        self._aiding = MotionAiding(vehicle.instruments, self._odometry)
        self._covariance = vehicle.covariance
        rng = np.random.default_rng([parameters.seed, 21])
        arrivals, stamps, twists = faulty(vehicle.twist_stamps, vehicle.twists, fault, rng)
        self._coming = list(zip(arrivals, stamps, twists, strict=True))[::-1]

    def initialise(self, given: GivenState) -> None:
        """Start from this cable at the next frame."""
        self._tracker.initialise(given)

    def process(self, image: Image, stamp: int) -> CableEstimate:
        """Take a frame into account, with the odometry that has come until then."""
        while self._coming and self._coming[-1][0] <= stamp:
            _, stated, twist = self._coming.pop()
            self._odometry.add(stated, twist, self._covariance)
        motion = self._aiding.motion(stamp, image)
        estimate = self._tracker.process(image, stamp, motion)
        self._aiding.observe(estimate)
        return estimate


_same_vehicle = lru_cache(maxsize=2)(simulated_vehicle)
"""Filters that are compared on one dive share its vehicle, which takes seconds to work out."""


@dataclass(frozen=True, slots=True)
class AidedFilter:
    """A filter with the odometry of a scenario, or without. It is sent to other processes.

    Attributes
    ----------
    name : str
        Name of the method in results.
    parameters : TrackerParameters
        All of them; the seed is that of the run.
    scenario : str
        Whose vehicle.
    fault : OdometryFault or None
        Fault of the odometry; None: there is no odometry.
    """

    name: str
    parameters: TrackerParameters
    scenario: str
    fault: OdometryFault | None

    def make(self, seed: int) -> Method:
        """Make a fresh tracker for the dive of a seed."""
        parameters = self.parameters.replaced({"seed": seed})
        if self.fault is None:
            return make_tracker(parameters)
        vehicle = _same_vehicle(self.scenario, seed, EXPERIMENT_ERRORS)
        return AidedMethod(parameters, vehicle, self.fault)
