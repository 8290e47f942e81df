"""Follow a target through a whole recording, and write table, pictures and video."""

from __future__ import annotations

import csv
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import cv2

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError, OutputError, RecordingError
from cable_tracker.evaluation.folder import output_folder
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.estimates import REFUSED, format_stamp
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.source import Source
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.model.start_text import DETECT, parse_box
from cable_tracker.target.model.state import PoseColumn
from cable_tracker.target.tracker import TargetTracker
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.visualisation.contact_sheet import ContactSheet
from cable_tracker.visualisation.target_overlay import draw_target
from cable_tracker.visualisation.video import VideoWriter

ESTIMATES = "estimates.csv"
VIDEO = "overlay.webm"
CONTACT_SHEET = "overlay.png"

HEADER = (
    "frame", "stamp", "status", "x", "y", "scale", "angle", "v_x", "v_y", "sigma_x", "sigma_y",
    "box_x0", "box_y0", "box_x1", "box_y1", "area", "presence", "n_eff", "ms",
)  # fmt: skip

SMALLEST_PICTURE = 480
"""Narrower frames are enlarged to this width in the pictures [px]."""


@dataclass(frozen=True, slots=True)
class TargetRow:
    """One frame of a followed target.

    Attributes
    ----------
    frame, stamp : int
        Number, and time [ns].
    status : str
        TRACKING, LOST, INITIALISING, or REFUSED for a frame that could not be used.
    estimate : TargetEstimate or None
        None for a refused frame.
    ms : float or None
        Time the tracker took [ms].
    """

    frame: int
    stamp: int
    status: str
    estimate: TargetEstimate | None
    ms: float | None

    def cells(self) -> list[str]:
        """Return the fields of the table; those of the state are empty without a claim."""
        cells = [str(self.frame), format_stamp(self.stamp), self.status]
        estimate = self.estimate
        if estimate is None:
            return cells + [""] * (len(HEADER) - len(cells))
        if self.status == TrackingStatus.TRACKING.value and estimate.box is not None:
            state, sigma = estimate.state, estimate.standard_deviations()
            numbers = [
                state[PoseColumn.X], state[PoseColumn.Y], estimate.scale, state[PoseColumn.ANGLE],
                state[PoseColumn.X_RATE], state[PoseColumn.Y_RATE], sigma[0], sigma[1],
                *estimate.box, estimate.area,
            ]  # fmt: skip
            cells += [repr(float(number)) for number in numbers]
        else:
            cells += [""] * 13
        cells += [repr(float(estimate.presence)), repr(float(estimate.effective_sample_size))]
        return [*cells, "" if self.ms is None else f"{self.ms:.3f}"]


def parse_start(init: str) -> TargetStart | None:
    """Return the start that the words say: `x0,y0,x1,y1`, or None for `detect`.

    Raises
    ------
    ParameterError
        They say neither, or the box has no area.
    """
    if init == DETECT:
        return None
    return parse_box(init)


def track_target(
    source: Source,
    tracker: TargetTracker,
    folder: Path,
    *,
    overwrite: bool,
    timing: bool,
    advance: Callable[[], None],
) -> tuple[list[TargetRow], RecordingError | None]:
    """Follow the target, and write the results into a folder.

    Parameters
    ----------
    source : Source
        The recording.
    tracker : TargetTracker
        Ready to begin.
    folder : Path
        Where the results appear.
    overwrite : bool
        Replace those of an earlier run.
    timing : bool
        Fill the column `ms`; without it, equal runs write equal tables.
    advance : callable
        Called after every frame.

    Returns
    -------
    rows : list of TargetRow
        One for every frame.
    damage : RecordingError or None
        Why the recording ended early.

    Raises
    ------
    OutputError
        The folder cannot be written.
    RecordingError
        No frame can be used.
    """
    rows: list[TargetRow] = []
    damage: list[RecordingError] = []
    with output_folder(folder, ESTIMATES, overwrite=overwrite) as content, ExitStack() as stack:
        video = stack.enter_context(VideoWriter(content / VIDEO))
        sheet = ContactSheet()
        for frame in _read(source, damage):
            row, picture = _follow(frame, tracker, timing)
            rows.append(row)
            if picture is not None:
                video.add(picture, frame.stamp)
                sheet.add(picture if sheet.wants_next() else None, frame.index)
            advance()
        if all(row.status == REFUSED for row in rows):
            raise damage[0] if damage else _nothing_usable(source, rows)
        with (content / ESTIMATES).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(HEADER)
            writer.writerows(row.cells() for row in rows)
        sheet.write(content / CONTACT_SHEET)
        if not (content / CONTACT_SHEET).is_file():
            raise OutputError(f"{folder / CONTACT_SHEET}: could not be written")
    return rows, damage[0] if damage else None


def _nothing_usable(source: Source, rows: list[TargetRow]) -> RecordingError:
    reason = f"none of the {len(rows)} frames can be used" if rows else "holds no frames"
    return RecordingError(f"{source.path}: {reason}; record it again")


def _read(source: Source, damage: list[RecordingError]) -> Iterator[Frame]:
    try:
        yield from source.frames()
    except RecordingError as error:
        damage.append(error)


def _follow(frame: Frame, tracker: TargetTracker, timing: bool) -> tuple[TargetRow, Image | None]:
    try:
        image = decode_bgr(frame.image)
        begin = time.perf_counter()
        estimate = tracker.process(image, frame.stamp)
        ms = (time.perf_counter() - begin) * 1e3
    except FrameError:
        return TargetRow(frame.index, frame.stamp, REFUSED, None, None), None
    particles = tracker.particles
    states = particles.states if particles is not None else None
    picture = draw_target(image, estimate, states)
    width = picture.shape[1]
    if width < SMALLEST_PICTURE:
        zoom = SMALLEST_PICTURE / width
        picture = cv2.resize(picture, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_LINEAR)
    status = estimate.status.value
    return TargetRow(frame.index, frame.stamp, status, estimate, ms if timing else None), picture
