"""Folder of results of a tracked recording: the common part of those of cables and targets."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from cable_tracker.atomic_output import output_folder
from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_writer import BagWriter, MessageSink, NoMessages
from cable_tracker.sequences.frame import Frame
from cable_tracker.visualisation.contact_sheet import ContactSheet
from cable_tracker.visualisation.video import VideoWriter

ESTIMATES = "estimates.csv"
VIDEO = "overlay.webm"
CONTACT_SHEET = "overlay.png"
BAG = "bag"

PLOTS = "estimates.png"
"""Plots of a cable's estimates."""

METRES = "metres.csv"
"""Table of a target in metres."""

FILES = (ESTIMATES, METRES, VIDEO, CONTACT_SHEET, PLOTS, BAG)
"""All files that are ever written into such a folder, in the order of display."""

SMALLEST_PICTURE, LARGEST_PICTURE = 480, 960
"""Narrower frames are enlarged, and wider ones shrunk, to these widths in the video [px]."""


@dataclass(frozen=True, slots=True)
class WantedResults:
    """Content of a result folder beside the table.

    Attributes
    ----------
    video : bool
        The frames with the tracker's belief drawn over them.
    bag : bool
        The messages that the node publishes.
    pictures : bool
        A contact sheet and, of a cable, the plots.
    """

    video: bool = True
    bag: bool = True
    pictures: bool = True


EVERYTHING = WantedResults()


def follow_all(frames: Iterable[Frame], follow: Callable[[Frame], None]) -> RecordingError | None:
    """Track all frames; return why the recording broke off, if it did."""
    try:
        for frame in frames:
            follow(frame)
    except RecordingError as error:
        return error
    return None


class Results(ABC):
    """Collects the results of a run; to be used as a context manager.

    The folder appears at its path when the context ends without an exception.

    Parameters
    ----------
    path : Path
        Path of the finished folder.
    overwrite : bool
        Replace the results of an earlier run. Nothing else is ever replaced, nor a folder in which
        the user has put other files.
    timing : bool
        Write the measured times into the table. Without them, equal runs write equal bytes.
    wanted : WantedResults
        Files to write beside the table.

    Attributes
    ----------
    path : Path
        Path of the finished folder.
    wanted : WantedResults
        Files that are written beside the table.
    bag : MessageSink
        Writer of messages; forgets them without a bag.

    Raises
    ------
    OutputError
        The path is taken, or the disk cannot be written.
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
        self.bag: MessageSink = NoMessages()
        self._overwrite = overwrite
        self._timing = timing
        self.wanted = wanted
        self._sheet = ContactSheet() if wanted.pictures else None
        self._video: VideoWriter | None = None

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            self._content = stack.enter_context(
                output_folder(
                    self.path,
                    ESTIMATES,
                    overwrite=self._overwrite,
                    is_own_name=FILES.__contains__,
                )
            )
            # What is entered last is closed first: the table is written when all else is there.
            stack.push(self._finish)
            if self.wanted.bag:
                self.bag = stack.enter_context(BagWriter(self._content / BAG))
            if self.wanted.video:
                self._video = stack.enter_context(VideoWriter(self._content / VIDEO))
            self._open_writers(stack)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._stack.__exit__(kind, error, traceback)

    def _finish(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if error is None:
            self._write_summaries()
            if self._sheet is not None:
                self._sheet.write(self._content / CONTACT_SHEET)

    @property
    def names(self) -> list[str]:
        """Names of the files in the finished folder, in the order of display."""
        return [name for name in FILES if (self.path / name).exists()]

    @abstractmethod
    def _open_writers(self, stack: ExitStack) -> None:
        """Open what is written frame by frame in `_content`."""

    @abstractmethod
    def _write_summaries(self) -> None:
        """Write the tables and pictures of the whole run into `_content`."""
