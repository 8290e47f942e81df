"""The folder that a tracked recording ends up in: table, video, pictures, bag."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Self

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError, OutputError
from cable_tracker.sequences.bag_writer import BagWriter
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.estimates import EstimateRow, write_estimates
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.output_folder import PartialOutput
from cable_tracker.visualisation.contact_sheet import ContactSheet
from cable_tracker.visualisation.overlay import draw_overlay
from cable_tracker.visualisation.plots import plot_estimates
from cable_tracker.visualisation.video import VideoWriter

ESTIMATES = "estimates.csv"
VIDEO = "overlay.webm"
CONTACT_SHEET = "overlay.png"
PLOTS = "estimates.png"
BAG = "bag"

SMALLEST_PICTURE = 480
"""Narrower frames are enlarged to this width in the pictures [px]."""


def _is_result_folder(path: Path) -> bool:
    return path.is_dir() and ((path / ESTIMATES).is_file() or not any(path.iterdir()))


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

    Attributes
    ----------
    path : Path
        Where it is to appear.
    rows : list of EstimateRow
        The table so far.
    truths : dict
        Ground truth by frame number, of the frames that have one.
    bag : BagWriter
        Where to write messages.

    Raises
    ------
    OutputError
        The path is taken, or the disk does not let us write.
    """

    def __init__(self, path: Path, *, overwrite: bool = False, timing: bool = True) -> None:
        self.path = path
        self._timing = timing
        self.rows: list[EstimateRow] = []
        self.truths: dict[int, CableState] = {}
        self._overwrite = overwrite
        self._sheet = ContactSheet()

    def __enter__(self) -> Self:
        self._folder = PartialOutput(
            self.path, overwrite=self._overwrite, is_ours=_is_result_folder
        )
        self._writers = ExitStack()
        try:
            self._content.mkdir()
            self.bag = self._writers.enter_context(BagWriter(self._content / BAG))
            self._video = self._writers.enter_context(VideoWriter(self._content / VIDEO))
        except OSError as error:
            self._abandon()
            raise OutputError(f"{self.path}: cannot be written ({error.strerror})") from error
        except BaseException:
            self._abandon()
            raise
        return self

    def _abandon(self) -> None:
        try:
            self._writers.close()
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
    ) -> None:
        """Add one frame.

        Parameters
        ----------
        frame : Frame
            The frame as it was recorded.
        row : EstimateRow
            What the tracker said.
        cloud : FloatArray or None
            Its particles, shape (N, 9): eight state columns and the weight.
        hypotheses : sequence of Hypothesis
            Where the cable may be, as far as it is known; for the pictures.
        """
        self.rows.append(row if self._timing else replace(row, ms=None))
        if frame.truth is not None:
            self.truths[frame.index] = frame.truth
        try:
            picture = decode_bgr(frame.image)
        except FrameError:
            return  # Refused frames stand in the table; there is no picture to show.
        self._add_picture(frame, row, picture, cloud, hypotheses)

    def _add_picture(
        self,
        frame: Frame,
        row: EstimateRow,
        picture: Image,
        cloud: FloatArray | None,
        hypotheses: Sequence[Hypothesis],
    ) -> None:
        overlay = draw_overlay(
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
        )
        self._video.add(overlay, frame.stamp)
        self._sheet.add(overlay, frame.index)

    def _write_summaries(self) -> None:
        try:
            write_estimates(self._content / ESTIMATES, self.rows)
            self._sheet.write(self._content / CONTACT_SHEET)
            plot_estimates(self._content / PLOTS, self.rows, self.truths)
        except OSError as error:
            raise OutputError(
                f"{self.path}: cannot be written ({error.strerror}); check the disk"
            ) from error
