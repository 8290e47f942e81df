"""From one recording to its routes and events, and to a folder that holds them."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.errors import FrameError, RecordingError, write_failure
from cable_tracker.metric.recorded import recorded_vehicle
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.instruments import Instrument
from cable_tracker.sequences.source import Source
from cable_tracker.survey.dive_route import DiveRoute, Profile
from cable_tracker.survey.events import Event, EventKind, Limits, find_events
from cable_tracker.survey.forwards import (
    ForwardDive,
    ForwardSettings,
    read_fix,
    track_forwards,
)
from cable_tracker.survey.frame_table import TRACKING
from cable_tracker.survey.looks import look_steps
from cable_tracker.survey.merging import PlacedRoute
from cable_tracker.survey.navigation import (
    Georeference,
    LocalFrame,
    Poses,
    georeference,
    joined_poses,
)
from cable_tracker.survey.on_disk import Disk
from cable_tracker.survey.outputs.frames import write_frames
from cable_tracker.survey.route import Course, make_routes
from cable_tracker.survey.second_look import look_again
from cable_tracker.survey.smoothing import smooth

FRAMES, ROUTES, SUMMARY, PICTURES = "frames.parquet", "routes.npz", "dive.json", "pictures"

THUMBNAIL = 240
"""Width of the pictures of events [px]."""

JPEG_QUALITY = 75

LATE = 2.0
"""Clocks of camera and navigation that differ by more cannot be brought together [s]."""


@dataclass(frozen=True, slots=True)
class SurveySettings:
    """How to survey a recording.

    Attributes
    ----------
    forward : ForwardSettings
        How to track.
    limits : Limits
        What is worth an event.
    datum : (float, float) or None
        Latitude and longitude of the local frame's origin [deg]; None: the frame of odometry.
    pictures : bool
        Whether to keep a picture of each event.
    """

    forward: ForwardSettings = field(default_factory=ForwardSettings)
    limits: Limits = field(default_factory=Limits)
    datum: tuple[float, float] | None = None
    pictures: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class SurveyedDive:
    """What has come of one recording.

    Attributes
    ----------
    name : str
        Of the recording.
    routes : tuple of PlacedRoute
        One for each connected piece; in the local frame if `on_earth`, else in that of odometry.
    events : tuple of Event
        Those that have no route: found and lost, of a recording without metres.
    on_earth : bool
        Whether the routes are in the local frame of the datum.
    notes : tuple of str
        What the user should know.
    frames, tracked : int
        How many there are, and in how many the cable is claimed.
    seconds : float
        Length of the recording.
    """

    name: str
    routes: tuple[PlacedRoute, ...]
    events: tuple[Event, ...]
    on_earth: bool
    notes: tuple[str, ...]
    frames: int
    tracked: int
    seconds: float


def find_datum(paths: Sequence[Path], settings: ForwardSettings) -> tuple[float, float] | None:
    """Return the first place on the earth that any of the recordings states [deg]; None: none."""
    for path in paths:
        try:
            with settings.open(path) as recording:
                vehicle = recorded_vehicle(recording, settings.choice, settings.vehicle)
        except RecordingError:
            continue
        if vehicle.source is None or Instrument.FIX not in vehicle.source.found.topics:
            continue
        with closing(vehicle.source.messages(only={Instrument.FIX})) as messages:
            for message in messages:
                fix = read_fix(message.message)
                if fix is not None:
                    return fix[0], fix[1]
    return None


def survey_recording(
    path: Path,
    folder: Path,
    settings: SurveySettings,
    advance: Callable[[int], None] = lambda count: None,
    *,
    name: str = "",
) -> SurveyedDive:
    """Track a recording, smooth it, find its events, and write all of it into a new folder.

    It is called by its own name, unless another is given.

    Raises
    ------
    RecordingError
        Nothing can be read of the recording.
    OutputError
        The folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise write_failure(folder, error) from error
    with settings.forward.open(path) as recording:
        dive = track_forwards(recording, settings.forward, advance, Disk(folder))
        dive.given_name = name
        surveyed, course = analyse(dive, settings)
        try:
            write_frames(folder / FRAMES, surveyed.name, dive, course)
            _write_summary(folder, surveyed)
            if settings.pictures:
                _write_pictures(recording, folder / PICTURES, surveyed)
        except OSError as error:
            raise write_failure(folder, error) from error
    return surveyed


def analyse(dive: ForwardDive, settings: SurveySettings) -> tuple[SurveyedDive, Course | None]:
    """Smooth a tracked dive and find its events; the course is None without metres."""
    rows, disk = dive.table.rows, dive.disk
    notes = list(dive.notes)
    poses = joined_poses(dive.poses, disk)
    places = disk.filled(len(rows), lambda part: poses.at(rows["stamp"][part]))
    counted = _counted(dive, places)
    notes += _faults(dive, poses, counted)
    course, routes, on_earth = None, [], False
    if counted.placed_partly and counted.in_metres:
        course = _course(dive, poses, places)
        if look_again(dive, course):
            course = _course(dive, poses, places)
        looks = course.looks
        earth = _on_earth(dive, poses, settings.datum, notes)
        on_earth = earth is not None
        placing = None if earth is None else _placing(earth)
        turn = 0.0 if earth is None else earth.turn
        routes = make_routes(looks, course.cable, rows, placing, turn, disk)
    name = dive.name
    placed = tuple(
        PlacedRoute(name, each, tuple(find_events(dive, course, each, settings.limits)))
        for each in routes
        if course is not None
    )
    seconds = float(rows["stamp"][-1] - rows["stamp"][0]) / 1e9
    events = () if placed else tuple(_events_in_time(dive))
    return (
        SurveyedDive(
            name, placed, events, on_earth, tuple(notes), len(rows), counted.tracked,
            max(seconds, 0.0),
        ),
        course,
    )  # fmt: skip


def _course(dive: ForwardDive, poses: Poses, places: FloatArray) -> Course:
    looks = look_steps(dive.table.rows, places, dive.disk)
    return Course(poses, looks, smooth(looks, dive.disk))


def _placing(
    earth: Georeference,
) -> Callable[[FloatArray, IndexArray], tuple[FloatArray, FloatArray]]:
    return earth.apply


def _on_earth(
    dive: ForwardDive, poses: Poses, datum: tuple[float, float] | None, notes: list[str]
) -> Georeference | None:
    if datum is None:
        return None
    earth = georeference(poses, dive.fixes, LocalFrame(*datum), dive.disk)
    if earth is None:
        notes.append(
            "too few fixes, or over too short a way, to lay the dive on the earth; its route is in"
            " the frame of odometry and is not merged"
        )
    elif earth.left_out:
        notes.append(f"{earth.left_out} fixes lie far off the way and do not count")
    return earth


@dataclass(slots=True)
class _Counted:
    """What there is of the rows of a dive.

    Attributes
    ----------
    tracked, in_metres, placed, placed_partly : int
        In how many the cable is claimed, is known in metres, and the vehicle's pose is known.
    back, ahead : float
        Least and largest step from one picture to the next, as far as beyond 0 [s].
    reasons : ndarray
        How many of the claims have no metres, by the number of the reason, shape (R,).
    """

    reasons: IndexArray
    tracked: int = 0
    in_metres: int = 0
    placed: int = 0
    placed_partly: int = 0
    back: float = 0.0
    ahead: float = 0.0


def _counted(dive: ForwardDive, places: FloatArray) -> _Counted:
    """Go through the rows of a dive, whose vehicle was at places (N, 3)."""
    rows, kinds = dive.table.rows, len(dive.table.reasons)
    found = _Counted(np.zeros(kinds, np.int64))
    before = rows["stamp"][:1]
    for part in dive.disk.blocks(len(rows)):
        some, known = rows[part], np.isfinite(places[part])
        claimed = some["status"] == TRACKING
        found.tracked += int(claimed.sum())
        found.in_metres += int(np.isfinite(some["aside"]).sum())
        found.placed += int(known.all(axis=1).sum())
        found.placed_partly += int(known.any(axis=1).sum())
        steps = np.diff(some["stamp"], prepend=before) / 1e9
        found.back = min(found.back, float(steps.min()))
        found.ahead = max(found.ahead, float(steps.max()))
        found.reasons += np.bincount(some["reason"][claimed], minlength=kinds)
        before = some["stamp"][-1:].copy()
    return found


def _faults(dive: ForwardDive, poses: Poses, counted: _Counted) -> list[str]:
    """Say why there is no route, or why it has gaps."""
    rows = dive.table.rows
    notes = []
    if not len(poses.stamps):
        notes.append("there is no odometry: the cable is known in pixels only, and has no route")
    elif not counted.placed_partly:
        apart = abs(float(rows["stamp"][0] - poses.stamps[0])) / 1e9
        notes.append(
            f"no odometry of the pictures' time: their clocks are {apart:.0f} s apart; set all"
            " clocks alike"
        )
    elif counted.placed < len(rows):
        share = (len(rows) - counted.placed) / len(rows)
        notes.append(f"odometry was silent, or on another clock, in {share:.0%} of the frames")
    if poses.jumps:
        notes.append(f"odometry began anew or jumped {len(poses.jumps)} times; the way was joined")
    if counted.back < 0.0 or counted.ahead > LATE:
        notes.append("the clock of the camera jumps; the tracker starts anew there")
    for number in np.flatnonzero(counted.reasons[1:]) + 1:
        share = counted.reasons[number] / counted.tracked
        notes.append(f"no metres in {share:.0%} of the claims: {dive.table.reasons[number]}")
    return notes


def _events_in_time(dive: ForwardDive) -> list[Event]:
    """Return when the cable was found and lost, of a dive without metres."""
    rows, nowhere = dive.table.rows, (float("nan"), float("nan"))
    events, before = list[Event](), 0
    for part in dive.disk.blocks(len(rows)):
        some = rows[part]
        claimed = (some["status"] == TRACKING).astype(np.int8)
        events += [
            Event(
                EventKind.FOUND if claimed[k] else EventKind.LOST,
                float("nan"), float("nan"), nowhere, int(some["stamp"][k]), int(some["frame"][k]),
                "in pixels only", dive.name,
            )
            for k in np.flatnonzero(np.diff(claimed, prepend=before))
        ]  # fmt: skip
        before = int(claimed[-1])
    return events


def _write_pictures(recording: Source, folder: Path, surveyed: SurveyedDive) -> None:
    """Keep a small picture of the frame of each event."""
    wanted = {
        event.frame for placed in surveyed.routes for event in placed.events if event.frame >= 0
    } | {event.frame for event in surveyed.events}
    if not wanted:
        return
    folder.mkdir(exist_ok=True)
    last = max(wanted)
    try:
        for frame in recording.frames(min(wanted)):
            if frame.index in wanted:
                _write_thumbnail(folder / f"{frame.index}.jpg", frame)
            if frame.index >= last:
                return
    except RecordingError:
        # Where it breaks off stands in the notes already.
        return


def _write_thumbnail(path: Path, frame: Frame) -> None:
    """Write a small picture of a frame; nothing if it cannot be decoded."""
    try:
        picture = decode_bgr(frame.image)
    except FrameError:
        return
    height = max(1, round(picture.shape[0] * THUMBNAIL / picture.shape[1]))
    small = cv2.resize(picture, (THUMBNAIL, height), interpolation=cv2.INTER_AREA)
    quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    path.write_bytes(cv2.imencode(".jpg", small, quality)[1].tobytes())


def _write_summary(folder: Path, surveyed: SurveyedDive) -> None:
    arrays: dict[str, Any] = {}
    for number, placed in enumerate(surveyed.routes):
        for name in DiveRoute.__dataclass_fields__:
            if name != "profile":
                arrays[f"{number}_{name}"] = getattr(placed.route, name)
        for name in Profile.__dataclass_fields__:
            arrays[f"{number}_profile_{name}"] = getattr(placed.route.profile, name)
    np.savez(folder / ROUTES, **arrays)
    content = {
        "name": surveyed.name,
        "on_earth": surveyed.on_earth,
        "notes": list(surveyed.notes),
        "frames": surveyed.frames,
        "tracked": surveyed.tracked,
        "seconds": surveyed.seconds,
        "routes": [[asdict(event) for event in each.events] for each in surveyed.routes],
        "events": [asdict(event) for event in surveyed.events],
    }
    (folder / SUMMARY).write_text(json.dumps(content), encoding="utf-8")


def read_surveyed(folder: Path) -> SurveyedDive:
    """Read what `survey_recording` has written.

    Raises
    ------
    RecordingError
        The folder holds no such thing.
    """
    try:
        content = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        routes = []
        with np.load(folder / ROUTES) as arrays:
            for number, events in enumerate(content["routes"]):
                routes.append(_placed(content["name"], arrays, number, events))
        return SurveyedDive(
            content["name"], tuple(routes), tuple(_event(each) for each in content["events"]),
            bool(content["on_earth"]), tuple(content["notes"]), int(content["frames"]),
            int(content["tracked"]), float(content["seconds"]),
        )  # fmt: skip
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise RecordingError(
            f"{folder}: holds no surveyed dive ({error}); survey the recording again"
        ) from error


def _placed(name: str, arrays: Any, number: int, events: list[dict[str, Any]]) -> PlacedRoute:  # noqa: ANN401
    profile = Profile(
        float(arrays[f"{number}_profile_start"]),
        arrays[f"{number}_profile_seen"],
        arrays[f"{number}_profile_in_view"],
    )
    columns = {
        field_name: arrays[f"{number}_{field_name}"]
        for field_name in DiveRoute.__dataclass_fields__
        if field_name not in ("profile", "start")
    }
    route = DiveRoute(start=float(arrays[f"{number}_start"]), profile=profile, **columns)
    return PlacedRoute(name, route, tuple(_event(each) for each in events))


def _event(content: dict[str, Any]) -> Event:
    x, y = content["place"]
    return Event(**{**content, "kind": EventKind(content["kind"]), "place": (float(x), float(y))})
