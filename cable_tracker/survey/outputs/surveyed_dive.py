"""Results of one recording of a survey, kept in its folder and read back."""

from __future__ import annotations

import json
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np

from cable_tracker.errors import RecordingError
from cable_tracker.survey.outputs.frames import FRAMES, check_frames
from cable_tracker.survey.routes.dive_route import DiveRoute, Profile
from cable_tracker.survey.routes.events import Event, EventKind
from cable_tracker.survey.routes.merging import PlacedRoute

RECORDINGS, PICTURES = "recordings", "pictures"
"""Folder of a survey with those of its recordings, and folder of a recording with pictures."""

ROUTES, SUMMARY = "routes.npz", "dive.json"

UNREADABLE = (OSError, EOFError, BadZipFile, zlib.error, KeyError, ValueError, TypeError)
"""Raised by what reads the files of a dive where they are damaged."""


@dataclass(frozen=True, slots=True, eq=False)
class SurveyedDive:
    """Results of one recording.

    Attributes
    ----------
    name : str
        Name of the recording.
    routes : tuple of PlacedRoute
        Routes, one for each connected piece; in the local frame if `on_earth`, else in that of
        odometry.
    events : tuple of Event
        Events that have no route: found and lost, of a recording without metres.
    on_earth : bool
        Whether the routes are in the local frame of the datum.
    notes : tuple of str
        Notes for the user.
    frames, tracked : int
        Number of frames, and of those in which the cable is claimed.
    seconds : float
        Length of the recording, without pauses and jumps of the clock [s].
    """

    name: str
    routes: tuple[PlacedRoute, ...]
    events: tuple[Event, ...]
    on_earth: bool
    notes: tuple[str, ...]
    frames: int
    tracked: int
    seconds: float


class Origin(NamedTuple):
    """Origin of the results of a recording.

    Attributes
    ----------
    recording : Path
        The whole path of the recording.
    datum : (float, float) or None
        Latitude and longitude of the local frame's origin [deg]; None: the frame of odometry.
    """

    recording: Path
    datum: tuple[float, float] | None


def write_summary(folder: Path, surveyed: SurveyedDive, origin: Origin) -> None:
    """Write what has come of a recording into its folder, for `read_surveyed`."""
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
        "recording": str(origin.recording),
        "datum": origin.datum,
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
    """Read what `survey_recording` has written, and see that its table of frames is whole.

    Raises
    ------
    RecordingError
        The folder holds no such thing.
    """
    try:
        check_frames(folder / FRAMES)
        content = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        routes = []
        with (folder / ROUTES).open("rb") as file, np.load(file) as arrays:
            for number, events in enumerate(content["routes"]):
                routes.append(_placed(content["name"], arrays, number, events))
        return SurveyedDive(
            content["name"], tuple(routes), tuple(_event(each) for each in content["events"]),
            bool(content["on_earth"]), tuple(content["notes"]), int(content["frames"]),
            int(content["tracked"]), float(content["seconds"]),
        )  # fmt: skip
    except UNREADABLE as error:
        raise RecordingError(
            f"{folder}: holds no surveyed dive ({error}); survey the recording again"
        ) from error


def read_origin(folder: Path) -> Origin | None:
    """Return the origin of the results in a folder; None where it is not given, or damaged."""
    try:
        content = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        recording, datum = content["recording"], content["datum"]
        if datum is not None:
            latitude, longitude = datum
            datum = (float(latitude), float(longitude))
        return Origin(Path(recording), datum)
    except UNREADABLE:
        return None


def _placed(name: str, arrays: Any, number: int, events: list[dict[str, Any]]) -> PlacedRoute:  # noqa: ANN401
    profile = Profile(
        float(arrays[f"{number}_profile_start"]),
        arrays[f"{number}_profile_seen"],
        arrays[f"{number}_profile_in_view"],
        arrays[f"{number}_profile_withheld"],
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
    return Event(
        **{
            **content,
            "kind": EventKind(content["kind"]),
            "place": (float(x), float(y)),
            "others": tuple(content.get("others", ())),
        }
    )
