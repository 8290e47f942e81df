"""The folder with what came of following a target through a recording."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Self

import cv2

from cable_tracker.arrays import Image
from cable_tracker.atomic_output import output_folder
from cable_tracker.errors import OutputError
from cable_tracker.offline.target_table import (
    ESTIMATES,
    HEADER,
    METRES,
    METRES_HEADER,
    TargetRow,
)
from cable_tracker.sequences.bag_writer import BagWriter, MessageSink, NoMessages
from cable_tracker.sequences.frame import Frame
from cable_tracker.visualisation.contact_sheet import ContactSheet
from cable_tracker.visualisation.video import VideoWriter

VIDEO = "overlay.webm"

CONTACT_SHEET = "overlay.png"

BAG = "bag"

SMALLEST_PICTURE = 480
"""Narrower frames are enlarged to this width in the pictures [px]."""


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
