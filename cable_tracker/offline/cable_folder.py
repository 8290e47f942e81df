"""Result folder of a cable tracked through a recording: table, video, pictures, bag."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError
from cable_tracker.offline.results import (
    ESTIMATES,
    LARGEST_PICTURE,
    PLOTS,
    SMALLEST_PICTURE,
    Results,
)
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.pictures.shown_levels import decode_shown
from cable_tracker.sequences.tables.estimates import EstimateRow, write_estimates
from cable_tracker.sequences.tables.stored_rows import StoredRows
from cable_tracker.visualisation.overlay import draw_overlay, with_presence
from cable_tracker.visualisation.palette import status_colour
from cable_tracker.visualisation.plots import plot_estimates
from cable_tracker.visualisation.video import DrawingThread


class CableFolder(Results):
    """Results of a tracked cable, see `Results`.

    Attributes
    ----------
    rows : StoredRows of EstimateRow
        The table so far.
    truths : dict
        Ground truth by frame number, of the frames that have one.
    widths : StoredRows of (float, int)
        Widths of the leading hypothesis and of the image, of the frames that have one [px].
    """

    def _open_writers(self, stack: ExitStack) -> None:
        self.truths: dict[int, CableState] = {}
        self.rows: StoredRows[EstimateRow] = StoredRows(self._content)
        self.widths: StoredRows[tuple[float, int]] = StoredRows(self._content)
        # Entered last, so that all is drawn before the video is closed.
        self._drawing = stack.enter_context(DrawingThread())

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
            Particles of the frame, shape (N, 9): eight state columns and the weight.
        hypotheses : sequence of Hypothesis
            Hypotheses of the frame, as far as they are known; for the pictures.
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
            picture = decode_shown(frame.image)
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
            caption = with_presence(row.status, row.presence)
            self._sheet.add(
                partial(draw, legend=False), frame.index, caption, status_colour(row.status)
            )

    def _write_summaries(self) -> None:
        write_estimates(self._content / ESTIMATES, self.rows)
        if self.wanted.pictures:
            plot_estimates(self._content / PLOTS, self.rows, self.truths)
