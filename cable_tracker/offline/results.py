"""Folder of results of a tracked recording: what those of cables and of targets share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from cable_tracker.atomic_output import output_folder
from cable_tracker.sequences.bag_writer import BagWriter, MessageSink, NoMessages

ESTIMATES = "estimates.csv"
VIDEO = "overlay.webm"
CONTACT_SHEET = "overlay.png"
BAG = "bag"


class Results(ABC):
    """Collects the results of a run; to be used as a context manager.

    The folder appears at its path when the context ends without an exception.

    Parameters
    ----------
    path : Path
        Path of the finished folder.
    overwrite : bool
        Replace the results of an earlier run. Nothing else is ever replaced.
    timing : bool
        Write the measured times into the table. Without them, equal runs write equal bytes.
    with_bag : bool
        Write the messages that the node publishes.

    Attributes
    ----------
    path : Path
        Path of the finished folder.
    with_bag : bool
        As given.
    bag : MessageSink
        Writer of messages; forgets them without a bag.

    Raises
    ------
    OutputError
        The path is taken, or the disk does not let us write.
    """

    def __init__(self, path: Path, *, overwrite: bool, timing: bool, with_bag: bool) -> None:
        self.path = path
        self.bag: MessageSink = NoMessages()
        self._overwrite = overwrite
        self._timing = timing
        self.with_bag = with_bag

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            self._content = stack.enter_context(
                output_folder(self.path, ESTIMATES, overwrite=self._overwrite)
            )
            # What is entered last is closed first: the table is written when all else is there.
            stack.push(self._finish)
            if self.with_bag:
                self.bag = stack.enter_context(BagWriter(self._content / BAG))
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

    @abstractmethod
    def _open_writers(self, stack: ExitStack) -> None:
        """Open what is written frame by frame in `_content`."""

    @abstractmethod
    def _write_summaries(self) -> None:
        """Write the tables and pictures of the whole run into `_content`."""
