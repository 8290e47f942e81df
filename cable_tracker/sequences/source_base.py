"""Base of all kinds of sources: checks, ground truth, and being closed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Generator, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self
from weakref import WeakSet

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences.encodings import check_image
from cable_tracker.sequences.frame import Frame


@dataclass(frozen=True, slots=True)
class ChosenRecording:
    """Which recording to open, and how.

    Attributes
    ----------
    path, topic, rate, truth, skip_bad_frames, allow_outside, with_truth
        See `cable_tracker.sequences.source.open_source`.
    """

    path: Path
    topic: str | None = None
    rate: float | None = None
    truth: Path | None = None
    skip_bad_frames: bool = False
    allow_outside: bool = False
    with_truth: bool = field(default=True, kw_only=True)


def damage(path: Path, count: int, reason: str) -> RecordingError:
    """Return the error for a recording that breaks off after some frames."""
    return RecordingError(
        f"{path}: damaged after {count} frames ({reason}); use the frames before it, or get an"
        " undamaged copy of the recording"
    )


class Source(ABC):
    """A recording that is open for reading: its frames, in order.

    Attributes
    ----------
    path : Path
        Path given by the user.
    frame_count : int or None
        Number of frames; None when it is unknown before all have been read.
    taken_rate : float or None
        At how many a second its pictures are taken, which have no times [1/s]; None: frames have.
    has_truth : bool
        Whether any frame is labelled.
    compressed : bool
        Whether the frames hold a `CompressedImage` instead of a `RawImage`.
    note : str
        Something the user should be told about the recording; empty if there is nothing.
    """

    def __init__(self, chosen: ChosenRecording) -> None:
        self.path = chosen.path
        self.frame_count: int | None = None
        self.has_truth = False
        self.compressed = False
        self.note = ""
        self.taken_rate: float | None = None
        self._skip_bad_frames = chosen.skip_bad_frames
        self._labels: Mapping[int, CableState] | None = None
        self._labels_by_stamp: Mapping[int, CableState] | None = None
        self._running: WeakSet[Generator[Frame]] = WeakSet()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        for frames in tuple(self._running):
            frames.close()

    def label(self, labels: Mapping[int, CableState]) -> None:
        """Attach ground truth to frames by their number, in place of all that the recording holds.

        A frame without a label then has no truth: labels of two origins must not be mixed.
        """
        self._labels = labels
        self.has_truth = bool(labels)

    def label_by_stamp(self, labels: Mapping[int, CableState]) -> None:
        """Attach ground truth to frames by their time [ns]; else as `label`."""
        self.label({})
        self._labels_by_stamp = labels
        self.has_truth = bool(labels)

    def has_frame_at(self, stamps: Container[int]) -> bool:
        """Tell whether a frame has one of some times [ns]; read up to the first.

        So it may be, too, where the recording breaks off before it can be known.
        """
        try:
            with closing(self._read_chosen(stamps.__contains__)) as items:
                return next(items, None) is not None
        except RecordingError:
            return True

    def frames(self, start: int = 0) -> Iterator[Frame]:
        """Read the frames from the beginning, or from a later one on.

        Every image is checked when its frame is handed out. Those before the start are passed over
        with as little work as their kind allows; damage among them is raised as elsewhere.

        Raises
        ------
        RecordingError
            While iterating, after the frames before it: a frame cannot be decoded (unless bad
            frames are to be skipped: then it is handed out, and decoding it raises FrameError), or
            the recording is damaged. After the last frame: a label belongs to none, where that was
            not known before.
        """
        return self._handed_out(self._read_to_end(start))

    def chosen_frames(self, wanted: Callable[[int], bool]) -> Iterator[Frame]:
        """Read the frames whose time [ns] is wanted; each is asked about once, in order.

        Others are passed over with as little work as their kind allows: they are not checked.

        Raises
        ------
        RecordingError
            As `frames`.
        """
        return self._handed_out(self._read_chosen(wanted))

    def _read_to_end(self, start: int) -> Generator[Frame]:
        """Yield the frames from one on, and then see that no label lies beyond the last."""
        count = 0
        with closing(self._read(start)) as items:
            for item in items:
                count = item.index + 1
                yield item
        last_label = max(self._labels or (), default=-1)
        if count and self.frame_count is None and last_label >= count:
            raise RecordingError(
                f"{self.path}: has only {count} frames, counted from 0, but frame {last_label} is"
                " labelled; correct the labels"
            )

    def _handed_out(self, items: Generator[Frame]) -> Iterator[Frame]:
        frames = self._checked(items)
        self._running.add(frames)
        return frames

    def frame_name(self, index: int) -> str:
        """Return the name of a frame for messages to the user."""
        return f"frame {index}"

    @abstractmethod
    def _read(self, start: int) -> Generator[Frame]:
        """Yield the frames from one on; raise RecordingError where the recording breaks off.

        Those that cannot be read have a `missing_image`.
        """

    def _read_chosen(self, wanted: Callable[[int], bool]) -> Generator[Frame]:
        """Yield the frames whose time is wanted; else as `_read`."""
        with closing(self._read(0)) as items:
            for item in items:
                if wanted(item.stamp):
                    yield item

    def _checked(self, items: Generator[Frame]) -> Generator[Frame]:
        with closing(items):
            for item in items:
                if not self._skip_bad_frames:
                    self._check(item)
                yield self._labelled(item)

    def _check(self, frame: Frame) -> None:
        try:
            check_image(frame.image)
        except FrameError as error:
            raise RecordingError(
                f"{self.path}: {self.frame_name(frame.index)} cannot be decoded ({error}); skip"
                " such frames with --skip-bad-frames (node: skip_bad_frames)"
            ) from error

    def _labelled(self, frame: Frame) -> Frame:
        if self._labels_by_stamp is not None:
            return replace(frame, truth=self._labels_by_stamp.get(frame.stamp))
        if self._labels is None:
            return frame
        return replace(frame, truth=self._labels.get(frame.index))
