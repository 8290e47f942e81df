"""Follow a target through a whole recording, and write table, pictures and video."""

from __future__ import annotations

import csv
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Self

import cv2

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError, OutputError, RecordingError
from cable_tracker.metric.recorded_target import RecordedSight
from cable_tracker.metric.relative_state import RelativeState
from cable_tracker.metric.target_facts import TARGET_METRES_KEYS, target_facts
from cable_tracker.metric.target_metres import TargetMetres
from cable_tracker.metric.withheld import Withheld
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import output_topics
from cable_tracker.sequences.bag_writer import BagWriter, MessageSink, NoMessages
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.estimates import REFUSED, format_stamp
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.jpeg import encode_jpeg
from cable_tracker.sequences.messages import (
    Message,
    make_compressed_image,
    make_header,
    make_report,
)
from cable_tracker.sequences.output_folder import output_folder
from cable_tracker.sequences.output_topics import OutputTopic
from cable_tracker.sequences.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.source import Source
from cable_tracker.sequences.target_messages import (
    box_corners,
    is_claimed,
    make_bearing,
    make_polygon,
    make_relative_pose,
    make_target,
    make_target_markers,
    make_target_particles,
    make_target_state,
    target_report_values,
)
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.model.start_text import DETECT, parse_box
from cable_tracker.target.model.state import PoseColumn
from cable_tracker.target.tracker import TargetTracker
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

METRES = "metres.csv"

METRES_HEADER = ("frame", "stamp", *TARGET_METRES_KEYS)

CLAIM_SIZE = 13
"""Columns of the table from `x` to `area`."""

SMALLEST_PICTURE = 480
"""Narrower frames are enlarged to this width in the pictures [px]."""


BAG = "bag"


@dataclass(frozen=True, slots=True)
class TargetRow:
    """One frame of a followed target.

    Attributes
    ----------
    frame, stamp : int
        Number, and time [ns].
    status : str
        TRACKING, LOST, INITIALISING, or REFUSED for a frame that could not be used.
    claim : tuple of float or None
        What is claimed: the columns `x` to `area` of the table; None without a claim.
    presence, n_eff : float or None
        None for a refused frame.
    ms : float or None
        Time the tracker took [ms].
    event : str
        What happened that a person should know.
    """

    frame: int
    stamp: int
    status: str
    claim: tuple[float, ...] | None = None
    presence: float | None = None
    n_eff: float | None = None
    ms: float | None = None
    event: str = ""

    def cells(self) -> list[str]:
        """Return the fields of the table; those of the state are empty without a claim."""
        cells = [str(self.frame), format_stamp(self.stamp), self.status]
        cells += [""] * CLAIM_SIZE if self.claim is None else [repr(x) for x in self.claim]
        cells += ["" if x is None else repr(x) for x in (self.presence, self.n_eff)]
        return [*cells, "" if self.ms is None else f"{self.ms:.3f}"]


def row_of(frame: Frame, estimate: TargetEstimate, ms: float | None) -> TargetRow:
    """Return the row of the table for a frame that was used."""
    claim = None
    if is_claimed(estimate) and estimate.box is not None:
        state, sigma = estimate.state, estimate.standard_deviations()
        numbers = [
            state[PoseColumn.X], state[PoseColumn.Y], estimate.scale, state[PoseColumn.ANGLE],
            state[PoseColumn.X_RATE], state[PoseColumn.Y_RATE], sigma[0], sigma[1],
            *estimate.box, estimate.area,
        ]  # fmt: skip
        claim = tuple(float(number) for number in numbers)
    return TargetRow(
        frame.index, frame.stamp, estimate.status.value, claim, float(estimate.presence),
        float(estimate.effective_sample_size), ms, estimate.event,
    )  # fmt: skip


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
    results: TargetFolder,
    advance: Callable[[], None],
    sight: RecordedSight | None = None,
) -> RecordingError | None:
    """Follow the target through a recording, and collect the results.

    Parameters
    ----------
    source : Source
        The recording.
    tracker : TargetTracker
        Ready to begin.
    results : TargetFolder
        Where the results go.
    advance : callable
        Called after every frame.
    sight : RecordedSight or None
        Instruments of the recording; None: everything stays in pixels.

    Returns
    -------
    RecordingError or None
        Why the recording ended early.
    """
    try:
        for frame in source.frames():
            _follow(frame, tracker, results, sight)
            advance()
    except RecordingError as error:
        return error
    return None


def _follow(
    frame: Frame, tracker: TargetTracker, results: TargetFolder, sight: RecordedSight | None
) -> None:
    messages = FrameMessages(results.bag, frame)
    if sight is not None:
        sight.advance(frame)
    try:
        image = decode_bgr(frame.image)
        begin = time.perf_counter()
        motion = None
        if sight is not None:
            motion = sight.camera_motion(frame.stamp, (image.shape[1], image.shape[0]))
        estimate = tracker.process(image, frame.stamp, motion)
        ms = (time.perf_counter() - begin) * 1e3
    except FrameError as error:
        messages.write_refusal(str(error))
        results.add(frame, TargetRow(frame.index, frame.stamp, REFUSED, event=str(error)), None)
        return
    particles = tracker.particles
    picture = draw_target(image, estimate, particles.states if particles is not None else None)
    facts: dict[str, str] = {}
    if sight is not None:
        metres = sight.take(estimate)
        messages.write_metres(metres, sight)
        facts = target_facts(metres, sight.settings.mounting.position)
        results.metres.append(metres_row(frame, facts))
    messages.write_estimate(estimate, particles, picture, ms, facts)
    results.add(frame, row_of(frame, estimate, ms), picture)


def metres_row(frame: Frame, facts: Mapping[str, str]) -> tuple[str, ...]:
    """Return a frame's row of the table in metres; empty cells where something is not told.

    Parameters
    ----------
    frame : Frame
        The frame.
    facts : mapping
        What its report says, see `target_facts`.
    """
    cells = (facts.get(key, "") for key in TARGET_METRES_KEYS)
    return (str(frame.index), format_stamp(frame.stamp), *cells)


class FrameMessages:
    """Writes the messages that the node would publish about one frame.

    Parameters
    ----------
    bag : MessageSink
        Takes them.
    frame : Frame
        The frame.
    """

    def __init__(self, bag: MessageSink, frame: Frame) -> None:
        self._bag = bag
        self._stamp = frame.stamp
        self._factory = RosbagsMessages()
        self._header = make_header(self._factory, frame.stamp, frame.frame_id)

    def _write(self, topic: OutputTopic, message: Message) -> None:
        self._bag.write(f"/{topic.name}", topic.type_name, message, self._stamp)

    def write_refusal(self, reason: str) -> None:
        """Write that there is no estimate."""
        factory, header = self._factory, self._header
        self._write(output_topics.STATE, make_target_state(factory, header, None))
        report = make_report(factory, header, REFUSED, {"event": reason})
        self._write(output_topics.TARGET_REPORT, report)

    def write_estimate(
        self,
        estimate: TargetEstimate,
        particles: Particles | None,
        picture: Image,
        ms: float,
        facts: Mapping[str, str],
    ) -> None:
        """Write everything in pixels about a frame that was used.

        Parameters
        ----------
        estimate : TargetEstimate
            What was found.
        particles : Particles or None
            The belief.
        picture : Image
            What the overlay shows.
        ms : float
            Time the tracker took [ms].
        facts : mapping
            What the report says in metres, see `target_facts`.
        """
        factory, header = self._factory, self._header
        self._write(output_topics.STATE, make_target_state(factory, header, estimate))
        count = particles.count if particles is not None else 0
        values = target_report_values(estimate, ms, count) | dict(facts)
        report = make_report(factory, header, estimate.status.value, values)
        self._write(output_topics.TARGET_REPORT, report)
        if is_claimed(estimate) and estimate.box is not None:
            self._write(output_topics.TARGET, make_target(factory, header, estimate))
            corners = box_corners(estimate.box)
            self._write(output_topics.BOX, make_polygon(factory, header, corners))
            if len(estimate.outline):
                outline = make_polygon(factory, header, estimate.outline)
                self._write(output_topics.CONTOUR, outline)
        if particles is not None:
            cloud = make_target_particles(factory, header, particles)
            self._write(output_topics.PARTICLES, cloud)
        markers = make_target_markers(factory, header, estimate, estimate.image_size)
        self._write(output_topics.MARKERS, markers)
        jpeg = make_compressed_image(factory, encode_jpeg(picture), header)
        self._write(output_topics.TARGET_OVERLAY, jpeg)

    def write_metres(self, metres: TargetMetres, sight: RecordedSight) -> None:
        """Write bearing and place, as far as they are known."""
        factory = self._factory
        if not isinstance(metres.ray, Withheld):
            self._write(output_topics.BEARING, make_bearing(factory, self._header, metres.ray))
        if isinstance(metres.relative, RelativeState):
            place = metres.relative.position() + sight.settings.mounting.position
            header = make_header(factory, self._stamp, sight.base_frame)
            covariance = metres.relative.position_covariance()
            pose = make_relative_pose(factory, header, place, covariance)
            self._write(output_topics.RELATIVE_POSE, pose)


class TargetFolder:
    """Collects the results of a run; to be used as a context manager.

    The folder appears at its path when the context ends without an exception.

    Parameters
    ----------
    path : Path
        Where it is to appear.
    overwrite : bool
        Replace the results of an earlier run. Nothing else is ever replaced.
    timing : bool
        Fill the column `ms`; without it, equal runs write equal tables.
    with_bag : bool
        Write the messages of the node.

    Attributes
    ----------
    rows : list of TargetRow
        The table so far.
    metres : list of tuple of str
        The table in metres so far; it is written if it has rows.
    bag : MessageSink
        Where to write messages.

    Raises
    ------
    OutputError
        The path is taken, or the disk does not let us write.
    """

    def __init__(self, path: Path, *, overwrite: bool, timing: bool, with_bag: bool) -> None:
        self.path = path
        self.rows: list[TargetRow] = []
        self.metres: list[tuple[str, ...]] = []
        self.bag: MessageSink = NoMessages()
        self._overwrite = overwrite
        self._timing = timing
        self._with_bag = with_bag
        self._sheet = ContactSheet()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of what it holds."""
        metres = (METRES,) if self.metres else ()
        return (ESTIMATES, *metres, VIDEO, CONTACT_SHEET, *((BAG,) if self._with_bag else ()))

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            self._content = stack.enter_context(
                output_folder(self.path, ESTIMATES, overwrite=self._overwrite)
            )
            # What is entered last is closed first: the table is written when all else is there.
            stack.push(self._write_table)
            self._video = stack.enter_context(VideoWriter(self._content / VIDEO))
            if self._with_bag:
                self.bag = stack.enter_context(BagWriter(self._content / BAG))
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._stack.__exit__(kind, error, traceback)

    def add(self, frame: Frame, row: TargetRow, picture: Image | None) -> None:
        """Add one frame, with the picture that shows what was found; None for a refused frame."""
        self.rows.append(row if self._timing else replace(row, ms=None))
        if picture is None:
            return
        width = picture.shape[1]
        if width < SMALLEST_PICTURE:
            zoom = SMALLEST_PICTURE / width
            picture = cv2.resize(picture, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_LINEAR)
        self._video.add(picture, frame.stamp)
        self._sheet.add(picture if self._sheet.wants_next() else None, frame.index)

    def _write_table(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if error is not None:
            return
        _write_csv(self._content / ESTIMATES, HEADER, (row.cells() for row in self.rows))
        if self.metres:
            _write_csv(self._content / METRES, METRES_HEADER, self.metres)
        self._sheet.write(self._content / CONTACT_SHEET)
        if not (self._content / CONTACT_SHEET).is_file():
            raise OutputError(
                f"{self.path / CONTACT_SHEET}: could not be written; check the folder and its"
                " free space"
            )


def _write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
