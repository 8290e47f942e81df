"""A vehicle that inspects a cable, with all its instruments, its bag, and the true cable.

The pilot sees where the cable is, buried or not, and keeps over it but for a slow wandering. The
cable's course belongs to one seed, the dive to another: several dives over one cable differ in
current, wandering and the errors of all instruments, and see the same sea bed.

World frame as in `vehicle`: x along the general course of the cable, y to its left.

The bag of such a dive holds everything that a vehicle's bag holds. Beside the storage file lie
`vehicle.yaml`, for what no topic contains, and `truth.json`: the true course of the cable, and the
built-in events along it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.atomic_output import write_bytes
from cable_tracker.sequences.bags.bag_writer import StorageFormat
from cable_tracker.sequences.bags.storage_files import TRUTH_FILE
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.cable_scene import (
    BURIAL_RAMP,
    SCENE_APPEARANCE,
    CableScene,
    cable_course,
    cable_of_seed,
    cable_points,
    nearest_along,
)
from cable_tracker.simulation.dive import SceneSettings, Seeds
from cable_tracker.simulation.instruments.instrument_messages import CAMERA
from cable_tracker.simulation.instruments.instrument_writer import (
    BEARING,
    FIX_SIGMA,
    ORIGIN,
    Tick,
    WrittenDive,
    to_east_north,
    write_ticks,
)
from cable_tracker.simulation.instruments.instruments import (
    USUAL_ERRORS,
    InstrumentSet,
)
from cable_tracker.simulation.rendering.appearance import Skin
from cable_tracker.simulation.rendering.laid_cable import BuriedStretch, Stretch, Tube
from cable_tracker.simulation.settings import check_range, check_seed, check_size
from cable_tracker.simulation.trajectory import Bands, Harmonics
from cable_tracker.simulation.vehicle import (
    Current,
    Vehicle,
    VelocityCommand,
)
from cable_tracker.stamps import stamp_at

TICKS = 4
"""Readings of odometry and imu per frame."""

WANDER_BANDS: Bands = ((0.01, 0.02), (0.03, 0.05))
"""Frequency bands of the pilot's place beside the cable [Hz]."""

AIM_AHEAD = 2.0
"""Distance along the cable of the point that the pilot steers for [m]."""

TURN_GAIN, MOST_TURN = 1.0, 0.4
"""Rate of turn per radian off the course [1/s], and the fastest [rad/s]."""

SWAY_GAIN, MOST_SWAY = 0.4, 0.2
"""Sideways velocity per metre beside the wanted place [1/s], and the highest [m/s]."""

CROSSING_RADIUS = 0.06
"""Radius of the cables that lie across [m]."""

EXCURSION_RAMP = 4.0
"""Way over which the pilot leaves the cable, and comes back [m]."""

COURSE_STEP = 0.25
"""Distance between two points of the true course [m]."""


@dataclass(frozen=True, slots=True)
class SurveyDiveSettings:
    """Settings of a simulated survey dive.

    Attributes
    ----------
    seed : int
        Not negative; draws current, wandering, and the errors of all instruments.
    cable_seed : int
        Not negative; draws the cable's course, and sea bed and growth.
    length : float
        Length of the cable's course that is followed, above 0 [m].
    buried : tuple of Stretch
        Stretches that sand hides.
    crossings : tuple of float
        Places along the cable where other cables lie across it [m].
    excursions : tuple of Stretch
        Stretches on which the pilot goes far aside.
    excursion : float
        Distance aside on these, positive to the left of the cable [m].
    altitude : float
        Altitude that the vehicle keeps, 0.3 to 50 [m].
    speed : float
        Speed through the water, 0.01 to 5 [m/s].
    current : float
        Speed of the water [m/s]; its direction is drawn.
    wander : float
        Largest distance by which the pilot strays from the cable [m].
    image_size : (int, int)
        Width and height [px], each 32 to 4096.
    rate : float
        Frames per second.

    Raises
    ------
    ParameterError
        A value is out of its range.
    """

    seed: int = 0
    cable_seed: int = 0
    length: float = 200.0
    buried: tuple[Stretch, ...] = ()
    crossings: tuple[float, ...] = ()
    excursions: tuple[Stretch, ...] = ()
    excursion: float = 1.6
    altitude: float = 2.0
    speed: float = 0.5
    current: float = 0.1
    wander: float = 0.25
    image_size: tuple[int, int] = (320, 240)
    rate: float = 12.5

    def __post_init__(self) -> None:
        check_seed(self.seed)
        check_seed(self.cable_seed, "cable_seed")
        check_size(self.image_size)
        check_range("length", self.length, (1.0, 1e5), "m of cable")
        check_range("altitude", self.altitude, (0.3, 50.0), "m above the bottom")
        check_range("speed", self.speed, (0.01, 5.0), "m/s")
        check_range("rate", self.rate, (1.0, 100.0), "frames per second")


def usual_survey(length: float, seed: int, cable_seed: int = 0) -> SurveyDiveSettings:
    """Return a survey with a buried stretch every 50 m, a crossing and an excursion every 100 m.

    What there is belongs to the cable, and is the same in all dives over it.

    Raises
    ------
    ParameterError
        There is no such length or seed.
    """
    plain = SurveyDiveSettings(seed, cable_seed, length)
    rng = np.random.default_rng([cable_seed, 7])
    buried, crossings = [], []
    for number in range(int(length // 50)):
        start = 50.0 * number + float(rng.uniform(12.0, 22.0))
        buried.append(Stretch(start, start + float(rng.uniform(4.0, 9.0))))
    for number in range(int(length // 100)):
        crossings.append(100.0 * number + float(rng.uniform(40.0, 48.0)))
    excursions = [Stretch(100.0 * n + 86.0, 100.0 * n + 89.0) for n in range(int(length // 100))]
    return replace(
        plain, buried=tuple(buried), crossings=tuple(crossings), excursions=tuple(excursions)
    )


class SurveyDive:
    """One survey dive along a cable.

    Attributes
    ----------
    scene : CableScene
        The cable with all that lies about it.
    camera : Camera
        The vehicle's camera; base_link is at its centre.
    cable_height : float
        Height of the cable's axis above the bottom [m].
    """

    def __init__(self, settings: SurveyDiveSettings) -> None:
        self._settings = settings
        own, cables = Seeds.of(settings.seed), Seeds.of(settings.cable_seed)
        motion_rng, reading_rng = (np.random.default_rng(seed) for seed in own.route.spawn(2))
        self._tube = cable_of_seed(settings.cable_seed)
        self.scene = CableScene(
            self._tube,
            SceneSettings(SCENE_APPEARANCE, stretches=self._stretches(), others=self._others()),
            settings.length,
            settings.image_size,
            (np.random.default_rng(cables.clutter), np.random.default_rng(cables.picture)),
        )
        self.camera = self.scene.camera
        self.cable_height = self._tube.height
        self._wander = Harmonics.random(settings.wander, WANDER_BANDS, motion_rng)
        current = Current.random(settings.current, np.random.default_rng(own.course))
        self._vehicle = Vehicle(current, self._start(), motion_rng)
        start = self._vehicle.state()
        self._instruments = InstrumentSet(USUAL_ERRORS, start, reading_rng)
        self._rng = reading_rng
        self._altitude = settings.altitude

    def ticks(self) -> Iterator[Tick]:
        """Yield the ticks up to the end of the cable, or to three times the expected duration."""
        settings = self._settings
        period = 1.0 / (TICKS * settings.rate)
        most = math.ceil(3.0 * settings.length / settings.speed / period)
        fix_every = max(1, round(1.0 / period))
        along = 0.0
        for number in range(most):
            if number:
                along = self._advance(number * period, along, period)
            state = self._vehicle.state()
            odometry = self._instruments.odometry(state, period if number else 0.0)
            imu = self._instruments.imu(state)
            fix = None
            if number % fix_every == 0:
                fix = state.position[:2] + FIX_SIGMA * self._rng.standard_normal(2)
            if number % TICKS:
                yield Tick(number * period, state, odometry, imu, fix=fix)
                continue
            self._altitude = self._instruments.altitude(state)
            image = raw_from_array(self.scene.picture(state, number * period), "mono8")
            stamp, truth = stamp_at(number * period), self.scene.true_state(state)
            frame = Frame(number // TICKS, stamp, image, CAMERA, truth)
            yield Tick(number * period, state, odometry, imu, self._altitude, fix, frame)
            if along >= settings.length:
                return

    def _stretches(self) -> tuple[BuriedStretch, ...]:
        return tuple(
            BuriedStretch(each.start, each.end, BURIAL_RAMP) for each in self._settings.buried
        )

    def _others(self) -> tuple[tuple[Tube, Skin], ...]:
        others = []
        for number, along in enumerate(self._settings.crossings):
            point, _ = self._tube.axis(np.array([along]))
            heading = math.radians(60.0 if number % 2 else -55.0)
            origin = (float(point[0, 0]), float(point[0, 1]))
            others.append((Tube(CROSSING_RADIUS, (), origin, heading), SCENE_APPEARANCE.skin))
        return tuple(others)

    def _start(self) -> FloatArray:
        points, directions = cable_points(self._tube, np.zeros(1))
        course = math.atan2(directions[0, 1], directions[0, 0])
        return np.array([*points[0, :2], self._settings.altitude, course])

    def _advance(self, seconds: float, along: float, period: float) -> float:
        """Steer and integrate the motion over a period [s]; return the new `along` [m]."""
        x, y, _, yaw = self._vehicle.pose
        along = nearest_along(self._tube, np.array([x, y]), along)
        points, directions = cable_points(self._tube, np.array([along, along + AIM_AHEAD]))
        course = math.atan2(directions[1, 1], directions[1, 0])
        left = np.array([-directions[0, 1], directions[0, 0]])
        beside = float((np.array([x, y]) - points[0, :2]) @ left)
        wanted = float(self._wander.values(np.array(seconds))) + self._aside(along)
        correction = math.atan2(wanted - beside, AIM_AHEAD)
        turn = TURN_GAIN * math.remainder(course + correction - yaw, 2 * math.pi)
        sway = SWAY_GAIN * (wanted - beside)
        command = VelocityCommand(
            surge=self._settings.speed,
            sway=min(max(sway, -MOST_SWAY), MOST_SWAY),
            turn=min(max(turn, -MOST_TURN), MOST_TURN),
        )
        self._vehicle.advance(command, self._altitude, period)
        return along

    def _aside(self, along: float) -> float:
        """Return the cross-track offset of the excursions, without wandering [m]."""
        most = 0.0
        for each in self._settings.excursions:
            rise = (along - each.start) / EXCURSION_RAMP + 1.0
            fall = (each.end - along) / EXCURSION_RAMP + 1.0
            most = max(most, min(1.0, rise, fall))
        return most * self._settings.excursion


def write_survey_bag(
    path: Path,
    settings: SurveyDiveSettings,
    *,
    storage: StorageFormat = StorageFormat.MCAP,
    overwrite: bool = False,
    advance: Callable[[float], None] = lambda way: None,
) -> WrittenDive:
    """Simulate a survey dive, and write it into a bag.

    Parameters
    ----------
    overwrite : bool
        Replace a bag that lies at the path.
    advance : callable
        Called after each picture with the position along the course [m].

    Raises
    ------
    OutputError
        The bag cannot be written.
    """
    dive = SurveyDive(settings)
    ticks = _reporting(dive.ticks(), advance)
    written = write_ticks(
        path, ticks, dive.camera, dive.cable_height, storage=storage, overwrite=overwrite
    )
    write_bytes(path / TRUTH_FILE, json.dumps(truth_of(settings)).encode())
    return written


def _reporting(ticks: Iterable[Tick], advance: Callable[[float], None]) -> Iterator[Tick]:
    """Yield ticks, and call `advance` after each picture with the position along the course [m]."""
    for tick in ticks:
        yield tick
        if tick.frame is not None:
            advance(float(tick.state.position[0]))


def truth_of(settings: SurveyDiveSettings) -> dict[str, object]:
    """Return the content of `truth.json`."""
    along = np.arange(-2.0, settings.length + 4.0, COURSE_STEP)
    course = cable_course(settings.cable_seed, along)[:, :2]
    return {
        "origin": ORIGIN,
        "bearing": BEARING,
        "along": along.tolist(),
        "world": course.tolist(),
        "east_north": to_east_north(course).tolist(),
        "buried": [[each.start, each.end] for each in settings.buried],
        "crossings": list(settings.crossings),
        "excursions": [[each.start, each.end] for each in settings.excursions],
    }
