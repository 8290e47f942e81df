"""A vehicle behind a moving target: the world of a chase, with its truth.

A red float is towed through the water, on a trajectory that winds and climbs. Now and then a cloud
of silt hides it. The camera looks straight ahead from a vehicle with inertia and drag in a current.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.metric.frames import rotation_of
from cable_tracker.simulation.instruments.instruments import USUAL_ERRORS, InstrumentSet
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.settings import WorldSettings
from cable_tracker.simulation.targets.background import TargetBackground, random_background
from cable_tracker.simulation.targets.bodies import ImagePose, buoy, paint
from cable_tracker.simulation.targets.sequence import HAZE
from cable_tracker.simulation.vehicle import (
    Current,
    Vehicle,
    VehicleState,
    VelocityCommand,
)
from cable_tracker.tracking.image_frame import Window, bounding_box, to_pixel
from cable_tracker.tracking.parameter_table import number

DIAMETER = 0.5
"""Diameter of the float [m]."""

CLEAR_RANGE = 9.0
"""Distance over which the float's colour fades to 1/e [m]."""

NEAREST = 0.4
"""Smallest distance before the camera at which the float is painted [m]."""

FIRST_DISTANCE = 3.0
"""Distance between the camera and the float at the start [m]."""

FIELD = 0.75
"""Focal length as a share of the picture's width."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChaseSettings(WorldSettings):
    """Settings of a chase, as the node `target_simulator` has them too."""

    duration: float = number(300.0, "s", 1.0, 1e5, "Simulated time after which the node ends.")
    speed: float = number(0.35, "m/s", 0.0, 2.0, "Speed of the target.")
    hidden_every: float = number(
        50.0, "s", 5.0, 1e5, "Interval between the beginnings of two clouds of silt."
    )
    hidden_for: float = number(
        6.0, "s", 0.0, 1e4, "Time for which a cloud of silt hides the target."
    )
    altitude: float = number(
        5.0, "m", 0.3, 20.0, "Altitude above the sea bed at which the vehicle begins."
    )
    current: float = number(
        0.05, "m/s", 0.0, 2.0, "Speed of the water current, in a random direction."
    )


@dataclass(frozen=True, slots=True, eq=False)
class ChaseView:
    """Picture of the camera, and the truth about it.

    Attributes
    ----------
    image : Image
        Picture, uint8, blue-green-red, shape (H, W, 3).
    mask : BoolArray
        Visible pixels of the target, shape (H, W).
    place : FloatArray
        Place of the target in base_link, shape (3,) [m].
    """

    image: Image
    mask: BoolArray
    place: FloatArray

    @property
    def box(self) -> Window | None:
        """Left, top, right, bottom of the mask, from the top left corner; None if out of view."""
        return bounding_box(self.mask)


@cache
def target_size() -> float:
    """Return the root of the area of the float's silhouette [m]: the parameter `target_size`."""
    unit = 120.0
    _, coverage = paint(buoy(0.0), ImagePose(150.0, 150.0, unit), (300, 300))
    return math.sqrt(float(coverage.sum())) / unit * DIAMETER


class ChaseWorld:
    """Vehicle, target and camera."""

    def __init__(self, settings: ChaseSettings) -> None:
        self.settings = settings
        seeds = np.random.SeedSequence([settings.seed, 17]).spawn(4)
        way_rng, motion_rng, own_rng, self._noise_rng = (np.random.default_rng(s) for s in seeds)
        self.camera = Camera(
            settings.image_size, FIELD * settings.image_size[0], mounting=math.pi / 2
        )
        around = math.ceil(2.0 * math.pi * self.camera.focal)
        width, height = settings.image_size
        # `_closed` lays one margin more beyond the round: both hold a view across the seam.
        self._background = _closed(
            random_background((around, height), way_rng, margin=width / 2 - 1), around
        )
        self._around = around
        rates, phases = way_rng.uniform(0.03, 0.2, 4), way_rng.uniform(0.0, 2.0 * math.pi, 4)
        self._turns = (rates, phases, way_rng.uniform(0.2, 0.5, 4))
        self._target = np.array([FIRST_DISTANCE, 0.0, settings.altitude])
        start = np.array([0.0, 0.0, settings.altitude, 0.0])
        current = Current.random(settings.current, motion_rng)
        self._vehicle = Vehicle(current, start, motion_rng)
        self.instruments = InstrumentSet(USUAL_ERRORS, self._vehicle.state(), own_rng)
        self.time = 0.0

    def advance(self, command: VelocityCommand, altitude: float, seconds: float) -> None:
        """Let time pass; see `Vehicle.advance`."""
        self._vehicle.advance(command, altitude, seconds)
        rates, phases, sizes = self._turns
        course = float((sizes * np.sin(rates * self.time + phases)).sum())
        climb = 0.05 * math.sin(0.11 * self.time + phases[0])
        speed = self.settings.speed
        self._target = self._target + seconds * np.array(
            [speed * math.cos(course), speed * math.sin(course), climb]
        )
        self.time += seconds

    def state(self) -> VehicleState:
        """Return the true pose and velocity of the vehicle now."""
        return self._vehicle.state()

    @property
    def is_hidden(self) -> bool:
        """Whether a cloud of silt is before the target."""
        settings = self.settings
        into = self.time % settings.hidden_every
        return self.time >= settings.hidden_every and into < settings.hidden_for

    def place(self, state: VehicleState) -> FloatArray:
        """Return the position of the target in base_link, at the camera, shape (3,) [m]."""
        there: FloatArray = rotation_of(state.angles).T @ (self._target - state.position)
        return there

    def view(self, state: VehicleState) -> ChaseView:
        """Return the next picture of the camera, with its truth."""
        width, height = self.settings.image_size
        focal = self.camera.focal
        roll, pitch, yaw = (float(angle) for angle in state.angles)
        offset = ((-yaw * focal) % self._around, math.tan(pitch) * focal)
        picture = self._background.view((width, height), offset, self.time)
        place = self.place(state)
        coverage = np.zeros((height, width), np.float32)
        if place[0] > NEAREST and not self.is_hidden:
            ahead, left, up = (float(value) for value in place)
            pose = ImagePose(
                *to_pixel(-focal * left / ahead, focal * up / ahead, (width, height)),
                focal * DIAMETER / float(np.linalg.norm(place)),
                -roll,
            )
            colours, coverage = paint(buoy(0.0), pose, (width, height))
            clear = math.exp(-float(np.linalg.norm(place)) / CLEAR_RANGE)
            colours = clear * colours + (1.0 - clear) * HAZE * coverage[..., None]
            picture = (1.0 - coverage)[..., None] * picture + colours
        image = self._background.recorded(picture, self.time, self._noise_rng)
        return ChaseView(image, coverage > 0.5, place)


def _closed(background: TargetBackground, around: int) -> TargetBackground:
    """Return a background closed to a ring: its right end goes over into the left one."""
    panorama, margin = background.panorama.copy(), background.margin
    # What lies beyond the round, on both sides, is what lies at its other end.
    share = np.linspace(0.0, 1.0, margin, dtype=np.float32)[None, :, None]
    begin, end = panorama[:, :margin].copy(), panorama[:, around : around + margin].copy()
    seam = (1.0 - share) * end + share * begin
    panorama[:, around : around + margin] = seam
    panorama[:, :margin] = seam
    right = panorama.shape[1] - (around + margin)
    wrapped = np.concatenate(
        (panorama[:, : around + margin], panorama[:, margin : margin + right + margin]), axis=1
    )
    return replace(background, panorama=np.ascontiguousarray(wrapped))
