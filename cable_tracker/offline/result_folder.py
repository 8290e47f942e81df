"""The folder that a tracked recording ends up in: table, video, pictures, bag."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Self

from cable_tracker.arrays import FloatArray
from cable_tracker.atomic_output import PartialOutput, holds
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError, write_failure
from cable_tracker.sequences.bag_writer import BagWriter, MessageSink, NoMessages
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.estimates import EstimateRow, write_estimates
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.stored_rows import StoredRows
from cable_tracker.visualisation.contact_sheet import ContactSheet
from cable_tracker.visualisation.drawing_thread import DrawingThread
from cable_tracker.visualisation.overlay import draw_overlay, with_presence
from cable_tracker.visualisation.palette import status_colour
from cable_tracker.visualisation.plots import plot_estimates
from cable_tracker.visualisation.video import VideoWriter

ESTIMATES = "estimates.csv"
VIDEO = "overlay.webm"
CONTACT_SHEET = "overlay.png"
PLOTS = "estimates.png"
BAG = "bag"

SMALLEST_PICTURE, LARGEST_PICTURE = 480, 960
"""Narrower frames are enlarged, and wider ones shrunk, to these widths in the video [px]."""


@dataclass(frozen=True, slots=True)
class WantedResults:
    """Content of a result folder beside the table.

    Attributes
    ----------
    video : bool
        The frames with all that the tracker believes drawn over them.
    bag : bool
        The messages that the node publishes.
    pictures : bool
        A contact sheet and the plots.
    """

    video: bool = True
    bag: bool = True
    pictures: bool = True

    def names(self) -> tuple[str, ...]:
        """Return the names of the files, in the order in which they are told."""
        wanted = (
            (ESTIMATES, True),
            (VIDEO, self.video),
            (CONTACT_SHEET, self.pictures),
            (PLOTS, self.pictures),
            (BAG, self.bag),
        )
        return tuple(name for name, is_wanted in wanted if is_wanted)


EVERYTHING = WantedResults()


class ResultFolder:
    """Collects the results of a run; to be used as a context manager.

    The folder appears at its path when the context ends without an exception.

    Parameters
    ----------
    path : Path
        Where it is to appear.
    overwrite : bool
        Replace the results of an earlier run. Nothing else is ever replaced.
    timing : bool
        Write the measured times into the table. Without them, equal runs write equal bytes.
    wanted : WantedResults
        Files to write beside the table.

    Attributes
    ----------
    path : Path
        Where it is to appear.
    rows : StoredRows of EstimateRow
        The table so far.
    truths : dict
        Ground truth by frame number, of the frames that have one.
    widths : StoredRows of (float, int)
        Widths of the leading hypothesis and of the image, of the frames that have one [px].
    bag : BagWriter or NoMessages
        Where to write messages.

    Raises
    ------
    OutputError
        The path is taken, or the disk does not let us write.
    """

    def __init__(
        self,
        path: Path,
        *,
        overwrite: bool = False,
        timing: bool = True,
        wanted: WantedResults = EVERYTHING,
    ) -> None:
        self.path = path
        self.wanted = wanted
        self._timing = timing
        self.truths: dict[int, CableState] = {}
        self._overwrite = overwrite
        self._sheet = ContactSheet() if wanted.pictures else None
        self._video: VideoWriter | None = None

    def __enter__(self) -> Self:
        self._folder = PartialOutput(self.path, overwrite=self._overwrite, is_ours=holds(ESTIMATES))
        self._writers = ExitStack()
        try:
            self._content.mkdir()
            self.rows: StoredRows[EstimateRow] = StoredRows(self._content)
            self.widths: StoredRows[tuple[float, int]] = StoredRows(self._content)
            self.bag: MessageSink = NoMessages()
            if self.wanted.bag:
                self.bag = self._writers.enter_context(BagWriter(self._content / BAG))
            if self.wanted.video:
                self._video = self._writers.enter_context(VideoWriter(self._content / VIDEO))
            # Entered last, so that all is drawn before the video is closed.
            self._drawing = self._writers.enter_context(DrawingThread())
        except OSError as error:
            self._abandon(error)
            raise write_failure(self.path, error) from error
        except BaseException as error:
            self._abandon(error)
            raise
        return self

    def _abandon(self, error: BaseException) -> None:
        """Close all writers with the error as their reason, so that none raises another one."""
        try:
            self._writers.__exit__(type(error), error, error.__traceback__)
        finally:
            self._folder.discard()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            self._writers.__exit__(kind, error, traceback)
            if error is None:
                self._write_summaries()
        except BaseException:
            self._folder.discard()
            raise
        if error is None:
            self._folder.commit()
        else:
            self._folder.discard()

    @property
    def _content(self) -> Path:
        return self._folder.content

    def add(
        self,
        frame: Frame,
        row: EstimateRow,
        cloud: FloatArray | None,
        hypotheses: Sequence[Hypothesis] = (),
        image_width: int = 0,
    ) -> None:
        """Add one frame.

        Parameters
        ----------
        frame : Frame
            The frame as it was recorded.
        row : EstimateRow
            Row of the frame in the table.
        cloud : FloatArray or None
            Its particles, shape (N, 9): eight state columns and the weight.
        hypotheses : sequence of Hypothesis
            Where the cable may be, as far as it is known; for the pictures.
        image_width : int
            Width of the frame [px]; needed with hypotheses.
        """
        self.rows.append(row if self._timing else replace(row, ms=None))
        if frame.truth is not None:
            self.truths[frame.index] = frame.truth
        if hypotheses:
            self.widths.append((hypotheses[0].state.width, image_width))
        if self._video is None and self._sheet is None:
            return
        self._drawing.do(lambda: self._draw(frame, row, cloud, hypotheses))

    def _draw(
        self,
        frame: Frame,
        row: EstimateRow,
        cloud: FloatArray | None,
        hypotheses: Sequence[Hypothesis],
    ) -> None:
        """Draw a frame into the video and onto the sheet, in the thread that draws."""
        try:
            picture = decode_bgr(frame.image)
        except FrameError:
            return  # Refused frames stand in the table; there is no picture to show.
        draw = partial(
            draw_overlay,
            picture,
            state=row.state,
            status=row.status,
            sigma=row.sigma,
            truth=frame.truth,
            cloud=cloud,
            hypotheses=hypotheses,
            presence=row.presence,
            caption=f"frame {frame.index}",
            minimum_width=SMALLEST_PICTURE,
            maximum_width=LARGEST_PICTURE,
        )
        if self._video is not None:
            self._video.add(draw(), frame.stamp)
        if self._sheet is not None:
            overlay = draw(legend=False) if self._sheet.wants_next() else None
            words = with_presence(row.status, row.presence)
            self._sheet.add(overlay, frame.index, words, status_colour(row.status))

    def _write_summaries(self) -> None:
        try:
            write_estimates(self._content / ESTIMATES, self.rows)
            if self._sheet is not None:
                self._sheet.write(self._content / CONTACT_SHEET)
                plot_estimates(self._content / PLOTS, self.rows, self.truths)
        except OSError as error:
            raise write_failure(self.path, error) from error
