"""Write a simulated survey dive into a bag, with everything that a vehicle's bag holds.

Beside the storage file lie `vehicle.yaml`, which says what no topic says, and `truth.json`, which
says how it was: the cable's course, and what stands out along it.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cable_tracker.atomic_output import write_bytes
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_writer import BagWriter, StorageFormat
from cable_tracker.sequences.bags.storage_files import TRUTH_FILE
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.messages.cable import make_state
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_image
from cable_tracker.simulation.instruments.instrument_messages import (
    CAMERA,
)
from cable_tracker.simulation.instruments.instrument_writer import (
    BEARING,
    ORIGIN,
    InstrumentWriter,
    Tick,
    to_east_north,
    vehicle_text,
)
from cable_tracker.simulation.instruments.survey_dive import (
    SurveyDive,
    SurveyDiveSettings,
)
from cable_tracker.simulation.seen_cable import cable_course
from cable_tracker.stamps import stamp_at

COURSE_STEP = 0.25
"""Distance between two points of the true course [m]."""


@dataclass(frozen=True, slots=True)
class WrittenDive:
    """Size of the dive that was written.

    Attributes
    ----------
    frames : int
        Pictures in the bag.
    seconds : float
        Length of the dive.
    """

    frames: int
    seconds: float


def write_survey_bag(
    path: Path,
    settings: SurveyDiveSettings,
    *,
    storage: StorageFormat = StorageFormat.MCAP,
    overwrite: bool = False,
    advance: Callable[[float], None] = lambda way: None,
) -> WrittenDive:
    """Dive, and write everything.

    Parameters
    ----------
    overwrite : bool
        Replace a bag that lies at the path.
    advance : callable
        Told after each picture how far along the course the vehicle is [m].

    Raises
    ------
    OutputError
        The bag cannot be written.
    """
    dive = SurveyDive(settings)
    frames, seconds = 0, 0.0
    vehicle = vehicle_text(dive.cable_height).encode()
    with BagWriter(path, storage, overwrite=overwrite, vehicle=vehicle) as bag:
        writer = _Writer(bag, dive.camera, dive.errors)
        for tick in dive.ticks():
            writer.write(tick)
            seconds = tick.seconds
            if tick.picture is not None:
                frames += 1
                advance(float(tick.state.position[0]))
    write_bytes(path / TRUTH_FILE, json.dumps(truth_of(settings)).encode())
    return WrittenDive(frames, seconds)


def truth_of(settings: SurveyDiveSettings) -> dict[str, object]:
    """Return what `truth.json` says."""
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


class _Writer(InstrumentWriter):
    """Writes the pictures of a survey too."""

    def write(self, tick: Tick) -> None:
        super().write(tick)
        if tick.picture is None:
            return
        stamp = stamp_at(tick.seconds)
        factory = self._factory
        at_camera = make_header(factory, stamp, CAMERA)
        self._write(node_topics.GROUND_TRUTH, make_state(factory, at_camera, tick.truth), stamp)
        image = make_image(factory, raw_from_array(tick.picture, "mono8"), at_camera)
        self._write(node_topics.IMAGE, image, stamp)
