"""Measure surveys of simulated dives against their truth, and write the table of docs/survey.md.

    python docs/survey_goals.py FOLDER [--dives 5] [--first-seed 11] [--length 200] [--rate 6.25]

Dives that lie in FOLDER already are used again. Each has a cable of its own.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import deserialise
from cable_tracker.simulation.cable_scene import cable_of_seed, cable_points
from cable_tracker.simulation.instruments.survey_dive import (
    SurveyDive,
    usual_survey,
    write_survey_bag,
)
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings as Simulated
from cable_tracker.simulation.rendering.clutter import Streak
from cable_tracker.simulation.rendering.laid_cable import Stretch, Tube
from cable_tracker.survey.curve_filter import SmoothedCable
from cable_tracker.survey.forward_pass import read_pose, track_forwards
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.recording import SurveySettings, analyse
from cable_tracker.survey.routes.dive_route import DiveRoute
from cable_tracker.survey.routes.events import Event, EventKind
from cable_tracker.survey.routes.route import Course
from cable_tracker.survey.smoother import smooth

TRUTH_TOPIC = "/ground_truth/odometry"
REGION = 1.96
"""Half of a 95 % region [standard deviations]."""

NEAR = 1.0
"""Largest distance of an event from the true one [m]."""

CLEAR = 6.0
"""Distance from the end of a dive within which events need not be found [m]."""

HIDDEN_SHARE = 0.4
"""Hidden share of the borders from which on an event that says so is right."""

HALF, HALF_STEP = 0.5, 0.05
"""Hidden share of the borders at which a hidden stretch ends, and step of the search for it [m]."""

LEAST_ACROSS = math.sin(math.radians(15.0))
"""Sine of the angle from the cable at which a line counts as across it."""

CROSSING_STEP = 0.2
"""Step along the cable in which crossings with a streak are searched [radii]."""

SHARE_LENGTH = 0.5
"""Length of cable over which its hidden share is computed [m]."""

HEADINGS = (
    "dive", "length [m]", "RMS [m]", "without the way back [m]", "inside 95 % regions [%]",
    "ends of hidden stretches off by at most [m]", "off the sand's own ends [m]",
    "events found", "false in 100 m",
    "times real time",
)  # fmt: skip


@dataclass(frozen=True)
class DiveResult:
    """Results of one dive; lengths in m."""

    name: str
    length: float
    rms: float
    forwards: float
    inside: float
    ends: float
    sand: float
    found: int
    expected: int
    false: tuple[str, ...]
    speed: float

    def row(self) -> tuple[str, ...]:
        """Return the cells of the table."""
        return (
            self.name, f"{self.length:.0f}", f"{self.rms:.3f}", f"{self.forwards:.3f}",
            f"{100 * self.inside:.1f}", f"{self.ends:.2f}", f"{self.sand:.2f}",
            f"{self.found} of {self.expected}",
            f"{100 * len(self.false) / self.length:.1f}", f"{self.speed:.0f}",
        )  # fmt: skip


class Truth:
    """The true course of the cable, and the true poses of the vehicle."""

    def __init__(self, path: Path, settings: Simulated) -> None:
        storage = open_bag(path)
        poses = [
            (each.time, *read_pose(deserialise(each, is_ros1=False))[:3])
            for each in storage.messages([TRUTH_TOPIC])
        ]
        table = np.array(poses)
        self._stamps, self._poses = table[:, 0], table[:, 1:]
        self._poses[:, 2] = np.unwrap(self._poses[:, 2])
        self.tube: Tube = cable_of_seed(settings.cable_seed)

    def cable_ahead(self, stamps: FloatArray, look: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return position along the cable, and lateral offset from the vehicle, (N,) each [m].

        They are taken on lines across the vehicle's heading, `look` (N,) ahead of it [m].
        """
        poses = np.column_stack([np.interp(stamps, self._stamps, each) for each in self._poses.T])
        ahead = np.column_stack((np.cos(poses[:, 2]), np.sin(poses[:, 2])))
        places = poses[:, :2] + look[:, None] * ahead
        along = places[:, 0].copy()
        for _ in range(8):
            points, directions = cable_points(self.tube, along)
            way = ((places - points[:, :2]) * ahead).sum(axis=1)
            along += way / (directions[:, :2] * ahead).sum(axis=1) * directions[:, 0]
        points, _ = cable_points(self.tube, along)
        apart = points[:, :2] - places
        return along, -apart[:, 0] * ahead[:, 1] + apart[:, 1] * ahead[:, 0]

    def headings(self, stamps: FloatArray) -> FloatArray:
        """Return the vehicle's true direction [rad]."""
        return np.interp(stamps, self._stamps, self._poses[:, 2])


def crossings_of(tube: Tube, streak: Streak) -> FloatArray:
    """Return the positions along a bent cable at which a streak crosses it, shape (N,) [m].

    A streak's places are in radii of the tube.
    """
    reach = streak.half_length + 1.0
    places = np.arange(streak.q - reach, streak.q + reach, CROSSING_STEP)
    points, directions = tube.axis(places * tube.radius)
    cos, sin = math.cos(streak.angle), math.sin(streak.angle)
    u, v = points[:, 0] / tube.radius - streak.p, points[:, 1] / tube.radius - streak.q
    across, along = u * cos + v * sin, v * cos - u * sin
    cosine = directions[:, 0] * cos + directions[:, 1] * sin
    before = np.flatnonzero(np.diff(np.signbit(across)))
    before = before[(np.abs(along) <= reach)[before] & (np.abs(cosine) >= LEAST_ACROSS)[before]]
    shares = across[before] / (across[before] - across[before + 1])
    met: FloatArray = (places[before] + shares * CROSSING_STEP) * tube.radius
    return met


class SeaBed:
    """Lines across the true cable, and the hidden share of its borders.

    Parameters
    ----------
    settings : SurveyDiveSettings
        Settings of the dive over it.
    """

    def __init__(self, settings: Simulated) -> None:
        self._settings = settings
        self._tube = cable_of_seed(settings.cable_seed)
        self._scene = SurveyDive(settings).scene

    def lines_across(self) -> FloatArray:
        """Return the positions at which cables, ropes and furrows cross it, shape (N,) [m]."""
        met = [crossings_of(self._tube, streak) for streak in self._scene.streaks]
        return np.sort(np.concatenate([self._settings.crossings, *met]))

    def hidden_share(self, along: FloatArray) -> FloatArray:
        """Return the hidden share of both borders about positions along the cable, shape (N,).

        `along` (N,) [m]; over `SHARE_LENGTH`, seen from above.
        """
        shares = np.empty(len(along))
        steps = np.linspace(-SHARE_LENGTH / 2, SHARE_LENGTH / 2, 21)
        for number, place in enumerate(along):
            points, _ = self._tube.axis(np.array([place]))
            position = np.array([*points[0, :2], self._settings.altitude])
            world = self._tube.silhouette(position[None], (place + steps)[None])[0]
            usable = np.isfinite(world).all(axis=-1)
            shares[number] = self._scene.hidden(position, world, usable).mean()
        return shares


def measure(path: Path, settings: Simulated) -> DiveResult:
    """Survey one dive and compare it with its truth."""
    survey = SurveySettings(pictures=False)
    begin = time.process_time()
    with survey.forward.open(path) as recording:
        dive = track_forwards(recording, path.name, survey.forward, Disk(), lambda _: None)
        surveyed, course = analyse(dive, survey)
    seconds = time.process_time() - begin
    if course is None or not surveyed.routes:
        raise SystemExit(f"{path}: no route; {surveyed.notes}")
    truth, cable = Truth(path, settings), course.cable
    look = dive.table.rows["look"][course.keyframes.first]
    look = np.where(np.isfinite(look), look, np.nanmedian(look))
    along, beside = truth.cable_ahead(course.keyframes.stamps.astype(float), look)
    on_route = _on_routes(cable, [each.route for each in surveyed.routes])
    errors = _lateral_errors(cable, beside)[on_route]
    sigmas = (np.sqrt(cable.covariances[:, 0, 0]) * np.cos(cable.states[:, 1]))[on_route]
    forwards = smooth(course.keyframes, dive.disk, backward_pass=False)
    mapping = _CourseMapping(course, along)
    events = [
        (event, *mapping.true_stretch(event, each.route))
        for each in surveyed.routes
        for event in each.events
    ]
    done = _truncated(settings, float(along.max()))
    found, expected, ends, sand = _judge_found(done, SeaBed(settings), events)
    return DiveResult(
        path.name,
        done.length,
        _rms(errors),
        _rms(_lateral_errors(forwards, beside)[on_route]),
        float((np.abs(errors) < REGION * sigmas).mean()),
        ends,
        sand,
        found,
        expected,
        _judge_false(settings, truth.tube, events),
        surveyed.seconds / seconds,
    )


def _lateral_errors(cable: SmoothedCable, beside: FloatArray) -> FloatArray:
    """Return the errors across a cable, whose true offsets from the vehicle are given, (S,) [m]."""
    errors: FloatArray = (cable.states[:, 0] - beside) * np.cos(cable.states[:, 1])
    return errors


def _truncated(settings: Simulated, reach: float) -> Simulated:
    """Return the settings of a dive that broke off, cut to the length that it reached [m]."""
    return replace(
        settings,
        length=min(settings.length, reach),
        buried=tuple(each for each in settings.buried if each.end < reach - CLEAR),
        crossings=tuple(each for each in settings.crossings if each < reach - CLEAR),
        excursions=tuple(each for each in settings.excursions if each.end < reach - CLEAR),
    )


class _CourseMapping:
    """Maps positions along a route to positions along the true course."""

    def __init__(self, course: Course, along: FloatArray) -> None:
        order = np.argsort(course.cable.along, kind="stable")
        self._own, self._true = course.cable.along[order], along[order]

    def true_stretch(self, event: Event, route: DiveRoute) -> tuple[float, float]:
        """Return start and end of an event on the true course [m]."""
        ends = np.interp(
            [route.start + event.along, route.start + event.end], self._own, self._true
        )
        return float(ends[0]), float(ends[1])


def _on_routes(cable: SmoothedCable, routes: Sequence[DiveRoute]) -> BoolArray:
    on_route = np.zeros(len(cable.along), bool)
    for route in routes:
        way = cable.along - route.start
        on_route |= (way >= 0.0) & (way <= route.along[-1])
    return on_route


def _rms(errors: FloatArray) -> float:
    return math.sqrt(float(np.mean(errors**2)))


Placed = tuple[Event, float, float]
"""An event, and its start and end on the true course [m]."""


def _half_hidden(bed: SeaBed, stretch: Stretch) -> Stretch:
    """Return the stretch about a buried one on which more than half of the borders is hidden."""

    def walk(place: float, step: float) -> float:
        while float(bed.hidden_share(np.array([place + step]))[0]) > HALF:
            place += step
        return place + step / 2

    return Stretch(walk(stretch.start, -HALF_STEP), walk(stretch.end, HALF_STEP))


def _judge_found(
    settings: Simulated, bed: SeaBed, events: Sequence[Placed]
) -> tuple[int, int, float, float]:
    """Return the built-in events found, their number, and the largest errors of ends [m].

    The errors are those of the hidden stretches, then those of the sand itself.
    """
    found, off, off_sand = 0, 0.0, 0.0
    for stretch in settings.buried:
        reported = [
            Stretch(start, end)
            for event, start, end in events
            if event.kind is EventKind.BURIED and start < stretch.end and end > stretch.start
        ]
        if reported:
            found += 1
            off = max(off, _ends_off(reported, _half_hidden(bed, stretch)))
            off_sand = max(off_sand, _ends_off(reported, stretch))
    for place in settings.crossings:
        found += any(
            event.kind is EventKind.CROSSING and abs(start - place) < NEAR
            for event, start, _ in events
        )
    for stretch in settings.excursions:
        found += any(
            event.kind is EventKind.ASIDE and start < stretch.end + NEAR and end > stretch.start
            for event, start, end in events
        )
    expected = len(settings.buried) + len(settings.crossings) + len(settings.excursions)
    return found, expected, off, off_sand


def _ends_off(reported: Sequence[Stretch], true: Stretch) -> float:
    """Return the error of the worse end, of the reported stretch where it is smallest [m]."""
    return min(max(abs(each.start - true.start), abs(each.end - true.end)) for each in reported)


def _judge_false(settings: Simulated, tube: Tube, events: Sequence[Placed]) -> tuple[str, ...]:
    """Return descriptions of the events without a cause on the sea bed or in the dive."""
    bed = SeaBed(settings)
    across = bed.lines_across()
    aside = tuple(Stretch(each.start - 6.0, each.end + 6.0) for each in settings.excursions)

    def explained(event: Event, start: float, end: float) -> bool:
        kind = event.kind
        if kind is EventKind.CROSSING:
            return bool((np.abs(across - start) < NEAR).any())
        if kind in (EventKind.BURIED, EventKind.FOUND, EventKind.LOST):
            reach = 0.0 if kind is EventKind.BURIED else NEAR
            shares = bed.hidden_share(np.arange(start - reach, end + reach + 0.1, 0.2))
            if float(np.median(shares) if reach == 0.0 else shares.max()) > HIDDEN_SHARE:
                return True
        if kind in (EventKind.FOUND, EventKind.LOST, EventKind.OUT_OF_VIEW, EventKind.ASIDE):
            near = (*aside, Stretch(-2.0, 3.0))
            return any(start < each.end + NEAR and end > each.start - NEAR for each in near)
        if kind is EventKind.BEND:
            return _sharpest(tube, start, end) > 0.08
        return False

    return tuple(
        f"{event.kind.value} at {start:.1f} m ({event.detail})"
        for event, start, end in events
        if not explained(event, start, end)
    )


def _sharpest(tube: Tube, start: float, end: float) -> float:
    along = np.arange(start - 1.0, end + 1.5, 0.25)
    _, directions = cable_points(tube, along)
    headings = np.unwrap(np.arctan2(directions[:, 1], directions[:, 0]))
    return float(np.abs(np.diff(headings) / 0.25).max())


def main() -> None:
    """Simulate what is missing, measure all, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--dives", type=int, default=5)
    parser.add_argument("--first-seed", type=int, default=11)
    parser.add_argument("--length", type=float, default=200.0)
    parser.add_argument("--rate", type=float, default=6.25)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    cv2.setNumThreads(1)  # As the command does: a processor for each recording.
    print("| " + " | ".join(HEADINGS) + " |\n|" + "---|" * len(HEADINGS), flush=True)
    false = []
    for seed in range(given.first_seed, given.first_seed + given.dives):
        settings = replace(usual_survey(given.length, seed, seed), rate=given.rate)
        path = given.folder / f"dive_{seed}"
        if not path.is_dir():
            write_survey_bag(path, settings)
        measured = measure(path, settings)
        print("| " + " | ".join(measured.row()) + " |", flush=True)
        false += [f"{measured.name}: {each}" for each in measured.false]
    print("\n".join(["", "Events that nothing explains:", *(false or ["none"])]))


if __name__ == "__main__":
    main()
