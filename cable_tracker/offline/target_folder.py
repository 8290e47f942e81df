"""Result folder of a target followed through a recording."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace

from cable_tracker.arrays import Image
from cable_tracker.offline.results import (
    ESTIMATES,
    LARGEST_PICTURE,
    METRES,
    SMALLEST_PICTURE,
    Results,
)
from cable_tracker.offline.target_table import HEADER, METRES_HEADER, TargetRow
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.tables.csv_tables import write_csv
from cable_tracker.sequences.tables.stored_rows import StoredRows
from cable_tracker.visualisation.overlay import resized


class TargetFolder(Results):
    """Results of a followed target, see `Results`.

    Attributes
    ----------
    rows : StoredRows of TargetRow
        The table so far.
    metres : StoredRows of tuple of str
        The table in metres so far; it is written if it has rows.
    """

    def _open_writers(self, stack: ExitStack) -> None:
        self.rows: StoredRows[TargetRow] = StoredRows(self._content)
        self.metres: StoredRows[tuple[str, ...]] = StoredRows(self._content)

    def add(self, frame: Frame, row: TargetRow, picture: Image | None) -> None:
        """Add one frame, with the picture of its result; None for a refused frame."""
        self.rows.append(row if self._timing else replace(row, ms=None))
        if picture is None:
            return
        picture, _ = resized(picture, SMALLEST_PICTURE, LARGEST_PICTURE)
        if self._video is not None:
            self._video.add(picture, frame.stamp)
        if self._sheet is not None:
            self._sheet.add(lambda: picture, frame.index)

    def _write_summaries(self) -> None:
        write_csv(self._content / ESTIMATES, HEADER, (row.cells() for row in self.rows))
        if self.metres:
            write_csv(self._content / METRES, METRES_HEADER, self.metres)
