"""`report.html`: one page with map, profile, events and pictures, which needs no network."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from cable_tracker.arrays import FloatArray
from cable_tracker.survey.outputs.maps import (
    SurveyMap,
    event_rows,
    kilometre_points,
    picture_name,
    rounded,
)
from cable_tracker.survey.routes.merging import MergedRoute

MOST_POINTS = 8000
"""Points of a route in the page; a longer one is thinned out."""

MOST_PICTURES = 400
"""Pictures in the page; the others lie beside it."""


@dataclass(frozen=True, slots=True)
class RecordingRow:
    """One recording in the table of the report.

    Attributes
    ----------
    name : str
        Name of the recording.
    state : str
        "done", or why not.
    frames, tracked : int
        Frames, and in how many the cable is claimed.
    seconds : float
        Length, without pauses and jumps of the clock.
    notes : tuple of str
        Remarks for the user.
    """

    name: str
    state: str
    frames: int = 0
    tracked: int = 0
    seconds: float = 0.0
    notes: tuple[str, ...] = ()


def write_report(
    path: Path, survey: SurveyMap, recordings: Sequence[RecordingRow], title: str
) -> None:
    """Write the page; pictures are looked for beside it."""
    pictures = _Pictures(path.parent)
    events = _event_data(survey, pictures)
    data = {
        "onEarth": survey.frame is not None,
        "routes": [
            _route_data(name, route)
            for name, route in zip(survey.names, survey.routes, strict=True)
        ],
        "events": events,
    }
    script = files("cable_tracker.survey.outputs").joinpath("report.js").read_text("utf-8")
    page = (
        _environment()
        .get_template("report.html.j2")
        .render(
            title=title,
            recordings=recordings,
            events=event_rows(survey),
            on_earth=survey.frame is not None,
            datum=""
            if survey.frame is None
            else f"{survey.frame.latitude:.7f}, {survey.frame.longitude:.7f}",
            routes=[
                _summary(name, route)
                for name, route in zip(survey.names, survey.routes, strict=True)
            ],
            pictured=[
                *(each["picture"] >= 0 for each in events),
                *(False for _ in survey.events_in_time),
            ],
            pictures=json.dumps(pictures.encoded),
            # "</script>" inside a text must not end the script.
            data=json.dumps(data, allow_nan=False).replace("<", "\\u003c"),
            script=script,
        )
    )
    path.write_text(page, encoding="utf-8")


def _environment() -> Environment:
    """Return the settings of the page's template."""
    return Environment(
        loader=PackageLoader("cable_tracker.survey", "outputs"),
        autoescape=True,
        undefined=StrictUndefined,
        # A number that is missing is an empty cell.
        finalize=lambda value: "" if value is None else value,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _summary(name: str, route: MergedRoute) -> Mapping[str, object]:
    return {
        "name": name,
        "length": f"{route.along[-1]:.1f}",
        "visible": _percent(route.visible),
        "sigma": f"{float(np.median(route.sigmas)):.3f}",
        "worst": f"{float(np.max(route.sigmas)):.3f}",
        "dives": ", ".join(route.recordings),
    }


def _percent(shares: FloatArray) -> str:
    """Return the mean of those shares (N,) that are known; empty where none is."""
    known = shares[np.isfinite(shares)]
    return f"{100.0 * float(known.mean()):.1f}" if len(known) else ""


def _route_data(name: str, route: MergedRoute) -> dict[str, Any]:
    stride = max(1, -(-len(route.along) // MOST_POINTS))
    chosen = np.unique(np.append(np.arange(0, len(route.along), stride), len(route.along) - 1))
    along, places = kilometre_points(route)
    return {
        "name": name,
        "along": rounded(route.along[chosen], 2),
        "x": rounded(route.places[chosen, 0], 3),
        "y": rounded(route.places[chosen, 1], 3),
        "heading": rounded(route.headings[chosen], 4),
        # The largest from each chosen point to the next: thinning hides no doubt.
        "sigma": rounded(np.maximum.reduceat(route.sigmas, chosen), 3),
        "visible": rounded(route.visible[chosen], 2),
        "diameter": rounded(route.diameters[chosen], 4),
        "aside": rounded(route.asides[chosen], 3),
        "kp": [rounded(along, 1), rounded(places[:, 0], 2), rounded(places[:, 1], 2)],
    }


class _Pictures:
    """Pictures of a page, each once: base64, apart from all else so that they are read late."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._numbers: dict[str, int] = {}
        self.encoded: list[str] = []

    def number(self, name: str) -> int:
        """Return the place of a picture among all; -1: there is none, or no room for it."""
        if name in self._numbers:
            return self._numbers[name]
        file = self._folder / name
        if not name or len(self.encoded) == MOST_PICTURES or not file.is_file():
            return -1
        self.encoded.append(base64.b64encode(file.read_bytes()).decode("ascii"))
        self._numbers[name] = len(self.encoded) - 1
        return self._numbers[name]


def _event_data(survey: SurveyMap, pictures: _Pictures) -> list[dict[str, Any]]:
    return [
        {
            "route": number,
            "kind": event.kind.value,
            "from": round(event.along, 2),
            "to": round(event.end, 2),
            "x": round(event.place[0], 3),
            "y": round(event.place[1], 3),
            "detail": event.detail,
            "recording": event.recordings,
            "picture": pictures.number(picture_name(survey, event)),
        }
        for number, route in enumerate(survey.routes)
        for event in route.events
    ]
