"""Any frame of a recording, by its number."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.recently_used import RecentlyUsed
from cable_tracker.sequences.source_base import Source

KEPT_BYTES = 256 << 20
"""Pixels that are kept in memory, as they were recorded."""

BEYOND_ALL = sys.maxsize
"""Number that no frame has: asking for it finds where the recording ends."""


def _is_far(here: int, there: int) -> bool:
    """Tell whether passing over all frames before one is less work than reading those between."""
    return there - here > there / 2


class FrameAccess:
    """Reads frames of a source in any order.

    Sources read forwards. A frame a little further on is reached by reading on, another one by
    starting anew there, unless it is among the last ones that are kept. From any thread.

    Parameters
    ----------
    kept_bytes : int
        Capacity of the cache of pixels [bytes].
    """

    def __init__(self, source: Source, kept_bytes: int = KEPT_BYTES) -> None:
        self.source = source
        self._kept: RecentlyUsed[Frame] = RecentlyUsed(kept_bytes)
        self._frames: Iterator[Frame] | None = None
        self._next = self._known = 0
        self._end: int | None = None
        self._damage: RecordingError | None = None
        self._stop: RecordingError | None = None
        self._lock = threading.Lock()

    @property
    def count(self) -> int | None:
        """Number of frames; None while it is unknown. No frame that was read is beyond it."""
        return self._end if self._end is not None else self.source.frame_count

    @property
    def damage(self) -> RecordingError | None:
        """Error at which reading of the recording ended; None as long as none was met."""
        return self._damage

    def frame(self, index: int) -> Frame:
        """Return a frame.

        Raises
        ------
        IndexError
            The recording ends before it, or the number is negative.
        RecordingError
            The recording is damaged before or at it. Frames behind it that were read remain.
        """
        if index < 0:
            raise IndexError(f"there is no frame {index}")
        with self._lock:
            kept = self._kept.get(index)
            return kept if kept is not None else self._read(index)

    def _read(self, index: int) -> Frame:
        self._check_end(index)
        if index == BEYOND_ALL:
            # The last frame is wanted next, and can be kept on the way.
            if self._frames is None or self._next < self._known:
                self._start(self._known)
        elif self._frames is None or index < self._next or _is_far(self._next, index):
            self._start(index)
        while True:
            frame = self._advance()
            if frame is None:
                self._stopped_before(index)
                continue
            self._next = frame.index + 1
            self._known = max(self._known, self._next)
            self._kept.put(frame.index, frame, len(frame.image.data))
            if frame.index >= index:
                return frame

    def _stopped_before(self, index: int) -> None:
        """Begin anew where the frame may be that is wanted, or say why there is none."""
        damage, self._stop = self._stop, None
        if self._next > self._known:
            # Begun beyond the end: where that is, only reading tells.
            self._start(self._known)
        elif self._next == self._known:
            self._end, self._damage, self._frames = self._next, damage, None
            self._check_end(index)
        elif self._next < index:
            # Frames behind this one were read before; they have not gone with it.
            self._start(min(index, self._known))
        else:
            self._frames = None
            raise damage or RecordingError(
                f"{self.source.path}: frame {index} is no longer there; see what has changed it"
            )

    def _start(self, index: int) -> None:
        self._frames, self._next = self.source.frames(index), index

    def _advance(self) -> Frame | None:
        assert self._frames is not None
        try:
            return next(self._frames, None)
        except RecordingError as error:
            self._stop = error
            return None

    def _check_end(self, index: int) -> None:
        if self._end is not None and index >= self._end:
            if self._damage is not None:
                raise self._damage
            raise IndexError(f"there is no frame {index}; the recording has {self._end}")
