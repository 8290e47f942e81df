"""Survey of one recording: routes and events, and the folder that holds them, with pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import FrameError, ParameterError, RecordingError, write_failure
from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.pictures.encoded_pictures import jpeg_bytes
from cable_tracker.sequences.pictures.shown_levels import decode_shown
from cable_tracker.sequences.source_base import Source
from cable_tracker.survey.dive_faults import count_rows, find_faults
from cable_tracker.survey.forward_pass import (
    ForwardDive,
    ForwardSettings,
    read_fix,
    track_forwards,
)
from cable_tracker.survey.frame_table import REFUSED, TRACKING
from cable_tracker.survey.georeference import Georeference, georeference
from cable_tracker.survey.keyframes import make_keyframes
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.outputs.frames import FRAMES, write_frames
from cable_tracker.survey.outputs.surveyed_dive import PICTURES, Origin, SurveyedDive, write_summary
from cable_tracker.survey.redetection import redetect_cable
from cable_tracker.survey.routes.events import Event, EventKind, Limits, find_events
from cable_tracker.survey.routes.merging import PlacedRoute
from cable_tracker.survey.routes.route import Course, make_routes
from cable_tracker.survey.smoother import smooth
from cable_tracker.survey.trajectory import (
    Trajectory,
    joined_trajectory,
    poses_of_rows,
)

FARTHEST_DATUM = 100e3
"""Distance of a dive from the datum up to which a plane serves: there 1e-4 of a length is lost [m].
"""

FIRST_FIXES = 100
"""Number of fixes among which the datum is chosen."""

THUMBNAIL = 240
"""Width of the pictures of events [px]."""

JPEG_QUALITY = 75


@dataclass(frozen=True, slots=True)
class SurveySettings:
    """How to survey a recording.

    Attributes
    ----------
    forward : ForwardSettings
        Settings of the forward pass.
    limits : Limits
        Thresholds of the events.
    datum : (float, float) or None
        Latitude and longitude of the local frame's origin [deg]; None: the frame of odometry.
    pictures : bool
        Whether to keep a picture of each event.
    """

    forward: ForwardSettings = field(default_factory=ForwardSettings)
    limits: Limits = field(default_factory=Limits)
    datum: tuple[float, float] | None = None
    pictures: bool = True


def find_datum(paths: Sequence[Path], settings: ForwardSettings) -> tuple[float, float] | None:
    """Return a place on the earth that the first recording with fixes states [deg]; None: none.

    Of its first fixes it is the one to which most are near: a receiver may begin with an old place.

    Raises
    ------
    ParameterError
        The user's vehicle file is not acceptable.
    """
    for path in paths:
        try:
            with settings.open(path) as recording:
                vehicle = recorded_vehicle(recording, settings.choice, settings.vehicle)
        except RecordingError:
            continue
        except ParameterError:
            if settings.vehicle is not None:
                raise
            # The file beside a recording is refused where that is surveyed.
            continue
        if vehicle.source is None or Instrument.FIX not in vehicle.source.found.topics:
            continue
        with closing(vehicle.source.messages(only={Instrument.FIX})) as messages:
            fixes = (read_fix(message.message) for message in messages)
            first = list(islice((fix[:2] for fix in fixes if fix is not None), FIRST_FIXES))
        if first:
            return middle_fix(np.array(first))
    return None


def middle_fix(fixes: FloatArray) -> tuple[float, float]:
    """Return the fix to which most others are near.

    Parameters
    ----------
    fixes : FloatArray
        Latitudes and longitudes, shape (N, 2), N > 0 [deg].
    """

    def usual_distance(fix: tuple[float, float]) -> float:
        return float(np.median(LocalFrame(*fix).distances(fixes[:, 0], fixes[:, 1])))

    positions = [(float(latitude), float(longitude)) for latitude, longitude in fixes]
    return min(positions, key=usual_distance)


def survey_recording(
    path: Path,
    folder: Path,
    settings: SurveySettings,
    advance: Callable[[int], None],
    *,
    name: str,
) -> SurveyedDive:
    """Track a recording, smooth it, find its events, and write all of it into a new folder.

    `advance` is called with every frame; `name` is the dive's name in the results.

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
        dive = track_forwards(recording, name, settings.forward, Disk(folder), advance)
        surveyed, course = analyse(dive, settings)
        try:
            write_frames(folder / FRAMES, surveyed.name, dive, course)
            write_summary(folder, surveyed, Origin(path.resolve(), settings.datum))
            if settings.pictures:
                write_pictures(recording, folder / PICTURES, surveyed)
        except OSError as error:
            raise write_failure(folder, error) from error
    return surveyed


def analyse(dive: ForwardDive, settings: SurveySettings) -> tuple[SurveyedDive, Course | None]:
    """Smooth a tracked dive and find its events; the course is None without metres."""
    rows, disk = dive.table.rows, dive.disk
    notes = list(dive.notes)
    trajectory = joined_trajectory(dive.poses, disk)
    poses = poses_of_rows(rows, trajectory, disk)
    maximum_gap = settings.forward.parameters.maximum_gap
    counted = count_rows(dive, poses, maximum_gap)
    notes += find_faults(dive, trajectory, counted, maximum_gap)
    course, routes, on_earth = None, [], False
    if counted.placed_partly and counted.in_metres:
        course = _course(dive, trajectory, poses)
        if redetect_cable(dive, course):
            course = _course(dive, trajectory, poses)
        keyframes = course.keyframes
        earth = _on_earth(dive, trajectory, settings.datum, notes)
        on_earth = earth is not None
        routes = make_routes(keyframes, course.cable, rows, disk, earth)
    name = dive.name
    placed = tuple(
        PlacedRoute(name, each, tuple(find_events(dive, course, each, settings.limits)))
        for each in routes
        if course is not None
    )
    events = () if placed else tuple(_events_in_time(dive))
    return (
        SurveyedDive(
            name, placed, events, on_earth, tuple(notes), len(rows), counted.tracked,
            counted.seconds,
        ),
        course,
    )  # fmt: skip


def _course(dive: ForwardDive, trajectory: Trajectory, poses: FloatArray) -> Course:
    keyframes = make_keyframes(dive.table.rows, poses, dive.disk)
    return Course(trajectory, keyframes, smooth(keyframes, dive.disk))


def _on_earth(
    dive: ForwardDive, trajectory: Trajectory, datum: tuple[float, float] | None, notes: list[str]
) -> Georeference | None:
    if datum is None:
        return None
    frame = LocalFrame(*datum)
    _, fixes = dive.fixes.arrays()
    far = float(np.median(frame.distances(fixes[:, 0], fixes[:, 1]))) if len(fixes) else 0.0
    if far > FARTHEST_DATUM:
        notes.append(
            f"the datum is {far / 1000.0:.0f} km from the fixes: give one near them with --datum,"
            " or look at the signs of what was given, and whether latitude comes first; the route"
            " is in the frame of odometry and is not merged"
        )
        return None
    earth = georeference(trajectory, dive.fixes, frame, dive.disk)
    if earth is None:
        notes.append(
            "too few fixes, or over too short a distance, to georeference the dive; its route is in"
            " the frame of odometry and is not merged"
        )
    elif earth.left_out:
        notes.append(f"{earth.left_out} fixes lie far off the trajectory and are ignored")
    return earth


def _events_in_time(dive: ForwardDive) -> list[Event]:
    """Return when the cable was found and lost, of a dive without metres."""
    rows, nowhere = dive.table.rows, (float("nan"), float("nan"))
    events, before = list[Event](), 0
    for part in dive.disk.blocks(len(rows)):
        # A picture that could not be used says nothing about the cable.
        some = rows[part][rows["status"][part] != REFUSED]
        claimed = (some["status"] == TRACKING).astype(np.int8)
        events += [
            Event(
                EventKind.FOUND if claimed[k] else EventKind.LOST,
                float("nan"), float("nan"), nowhere, int(some["stamp"][k]), int(some["frame"][k]),
                "in pixels only", dive.name,
            )
            for k in np.flatnonzero(np.diff(claimed, prepend=before))
        ]  # fmt: skip
        before = int(claimed[-1]) if len(claimed) else before
    return events


def write_pictures(recording: Source, folder: Path, surveyed: SurveyedDive) -> None:
    """Keep small pictures of the frames of each event.

    Of its end, too: along the cable the other way that is where it begins.
    """
    events = [*surveyed.events, *(each for placed in surveyed.routes for each in placed.events)]
    wanted = {frame for each in events for frame in (each.frame, each.end_frame) if frame >= 0}
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
        picture = decode_shown(frame.image)
    except FrameError:
        return
    height = max(1, round(picture.shape[0] * THUMBNAIL / picture.shape[1]))
    small = cv2.resize(picture, (THUMBNAIL, height), interpolation=cv2.INTER_AREA)
    path.write_bytes(jpeg_bytes(small, JPEG_QUALITY))
