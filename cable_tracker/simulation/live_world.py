"""Closed-loop simulation: a vehicle that follows velocity commands above a cable.

The world frame is that of `vehicle`: x along the general course of the cable, y to its left. The
renderer's has x across to the right and y along.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.simulation.cable_scene import (
    BURIAL_RAMP,
    SCENE_APPEARANCE,
    CableScene,
    bent_cable,
    cable_points,
    nearest_along,
)
from cable_tracker.simulation.dive import SceneSettings, Seeds
from cable_tracker.simulation.instruments.instruments import USUAL_ERRORS, InstrumentSet
from cable_tracker.simulation.rendering.laid_cable import BuriedStretch
from cable_tracker.simulation.settings import WorldSettings
from cable_tracker.simulation.vehicle import (
    Current,
    Vehicle,
    VehicleState,
    VelocityCommand,
)
from cable_tracker.tracking.parameter_table import number

START_ASIDE, START_TURNED = 0.4, math.radians(8.0)
"""Largest distance from the cable and largest angle to it at the start [m, rad]."""

LEAST_COSINE = 0.1
"""A cable that runs more across the vehicle is as far beside it as at that cosine of the angle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveSettings(WorldSettings):
    """Settings of the closed-loop simulation, as the node `simulator` has them too."""

    length: float = number(100.0, "m", 1.0, 1e5, "Length of the cable; the node ends at its end.")
    buried: float = number(
        5.0,
        "m",
        0.0,
        1e5,
        "Length of the stretch under sand in the middle of the cable.",
    )
    altitude: float = number(
        2.0, "m", 0.3, 20.0, "Altitude above the sea bed that the vehicle keeps."
    )
    current: float = number(
        0.1, "m/s", 0.0, 2.0, "Speed of the water current, in a random direction."
    )

    def check_together(self) -> None:
        """Refuse a buried stretch that is longer than the cable.

        Raises
        ------
        ParameterError
            It is.
        """
        if self.buried > self.length:
            raise ParameterError(f"buried is {self.buried}: give 0 m to the length of the cable")

    @property
    def buried_from(self) -> float:
        """Position along the course at which the sand begins [m]."""
        return (self.length - self.buried) / 2


@dataclass(frozen=True, slots=True)
class TrueCrossTrack:
    """True cross track: the cable relative to the vehicle.

    Attributes
    ----------
    along : float
        Position of the nearest point along the cable's course [m].
    error : float
        Distance to that point; positive: the cable is to the left of the vehicle, seen in the
        cable's direction [m].
    offset : float
        y of the cable at x = 0, in the vehicle's level frame [m].
    heading : float
        Direction of the cable at its nearest point, from the vehicle's; positive: the cable leads
        to the left [rad].
    """

    along: float
    error: float
    offset: float
    heading: float


class LiveWorld:
    """World of the closed-loop simulation, `simulate --live`.

    Parameters
    ----------
    settings : LiveSettings
        Settings of course, burial and vehicle.

    Attributes
    ----------
    camera : Camera
        The vehicle's camera; base_link is at its centre.
    instruments : InstrumentSet
        The vehicle's instruments.
    cable_height : float
        Height of the cable's axis above the bottom [m].
    time : float
        Time since the beginning [s].
    """

    def __init__(self, settings: LiveSettings) -> None:
        self.settings = settings
        seeds = Seeds.of(settings.seed)
        course_rng = np.random.default_rng(seeds.course)
        motion_rng, own_rng = (np.random.default_rng(seed) for seed in seeds.route.spawn(2))
        self._tube = bent_cable(course_rng)
        self._scene = CableScene(
            self._tube,
            SceneSettings(SCENE_APPEARANCE, stretches=self._stretches()),
            settings.length,
            settings.image_size,
            (np.random.default_rng(seeds.clutter), np.random.default_rng(seeds.picture)),
        )
        self.camera = self._scene.camera
        self.cable_height = self._tube.height
        current = Current.random(settings.current, course_rng)
        self._vehicle = Vehicle(current, self._start(motion_rng), motion_rng)
        self.instruments = InstrumentSet(USUAL_ERRORS, self._vehicle.state(), own_rng)
        self.time = 0.0

    def _stretches(self) -> tuple[BuriedStretch, ...]:
        settings = self.settings
        if not settings.buried:
            return ()
        start = settings.buried_from
        return (BuriedStretch(start, start + settings.buried, BURIAL_RAMP),)

    def _start(self, rng: np.random.Generator) -> FloatArray:
        """Return the pose at the beginning: near the cable, which is in view."""
        point, direction = (part[0] for part in self.cable_at(np.zeros(1)))
        aside = float(rng.uniform(-START_ASIDE, START_ASIDE))
        turned = float(rng.uniform(-START_TURNED, START_TURNED))
        course = math.atan2(direction[1], direction[0])
        left = np.array([-math.sin(course), math.cos(course)])
        place = point[:2] + aside * left
        return np.array([*place, self.settings.altitude, course + turned])

    def state(self) -> VehicleState:
        """Return the true pose and velocity of the vehicle now."""
        return self._vehicle.state()

    def advance(self, command: VelocityCommand, altitude: float, seconds: float) -> None:
        """Integrate the motion; `altitude` is the last reading of the altimeter [m]."""
        self._vehicle.advance(command, altitude, seconds)
        self.time += seconds

    def cable_at(self, along: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points and directions of the cable in the world, each (N, 3), at places (N,)."""
        return cable_points(self._tube, along)

    def cross_track(self, state: VehicleState) -> TrueCrossTrack:
        """Return the true cross track of a vehicle."""
        along = nearest_along(self._tube, state.position[:2], float(state.position[0]))
        point, direction = (part[0] for part in self.cable_at(np.array([along])))
        aside = point[:2] - state.position[:2]
        error = float(direction[0] * aside[1] - direction[1] * aside[0])
        heading = math.atan2(direction[1], direction[0]) - float(state.angles[2])
        heading = math.remainder(heading, 2 * math.pi)
        # Beyond a right angle what is to the left of the cable is to the right of the vehicle.
        cos = math.cos(heading)
        offset = error / math.copysign(max(abs(cos), LEAST_COSINE), cos)
        return TrueCrossTrack(along, error, offset, heading)

    def picture(self, state: VehicleState) -> Image:
        """Render the next picture: grey, uint8, shape (H, W)."""
        return self._scene.picture(state, self.time)

    def true_state(self, state: VehicleState) -> CableState | None:
        """Return the true state of the cable in the image; None if none of it is visible."""
        return self._scene.true_state(state)
