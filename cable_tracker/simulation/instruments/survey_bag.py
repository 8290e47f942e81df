"""Write a simulated survey dive into a bag, with everything that a vehicle's bag holds.

Beside the storage file lie `vehicle.yaml`, for what no topic contains, and `truth.json`: the true
course of the cable, and the built-in events along it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from cable_tracker.atomic_output import write_bytes
from cable_tracker.sequences.bags.bag_writer import StorageFormat
from cable_tracker.sequences.bags.storage_files import TRUTH_FILE
from cable_tracker.simulation.cable_scene import cable_course
from cable_tracker.simulation.instruments.instrument_writer import (
    BEARING,
    ORIGIN,
    Tick,
    WrittenDive,
    to_east_north,
    write_ticks,
)
from cable_tracker.simulation.instruments.survey_dive import (
    SurveyDive,
    SurveyDiveSettings,
)

COURSE_STEP = 0.25
"""Distance between two points of the true course [m]."""


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
