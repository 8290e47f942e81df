"""Times of the frames of a video: those of its container, where they are not a steady rate's."""

from __future__ import annotations

import math

from cable_tracker.stamps import FIRST_STAMP, NANOSECONDS, stamp_of_frame

ROUNDING = 2_000_000
"""Containers round times to a millisecond, some to 1/600 s; what differs by less is steady [ns]."""

LONGEST_GAP = 86_400 * NANOSECONDS
"""No recorder pauses longer within a file; a time further ahead is damage [ns]."""


class FrameClock:
    """Gives the frames of a video their stamps, one after the other.

    They are those of a steady rate as long as the container's times agree with it to within their
    rounding; where they do not, the container's time is taken, and the rate goes on from there. A
    time that does not come after that of the frame before is not believed.

    Parameters
    ----------
    rate : float
        Frames per second.
    is_steady : bool
        Whether the container's times are not to be used at all.
    """

    def __init__(self, rate: float, *, is_steady: bool = False) -> None:
        self._rate = rate
        self._is_steady = is_steady
        self._rounding = min(ROUNDING, NANOSECONDS / rate / 2)
        self._index = -1
        self._first_time = 0.0
        self._anchor, self._anchor_stamp = 0, FIRST_STAMP
        self._last = FIRST_STAMP

    def next_stamp(self, container_time: float) -> int:
        """Return the stamp of the next frame [ns].

        Parameters
        ----------
        container_time : float
            Time of the frame according to the container [ms], NaN where it has none; of the first
            one that is the beginning, 0.
        """
        self._index += 1
        if not self._index:
            self._first_time = container_time if math.isfinite(container_time) else 0.0
        steady = stamp_of_frame(self._index - self._anchor, self._rate)
        self._last = self._corrected(steady - FIRST_STAMP + self._anchor_stamp, container_time)
        return self._last

    def _corrected(self, steady: int, container_time: float) -> int:
        """Return the stamp of a frame [ns], and go on from it where it is not the steady one."""
        after_first = container_time - self._first_time
        if self._is_steady or not math.isfinite(after_first):
            return steady
        stamp = FIRST_STAMP + round(after_first * 1e6)
        if abs(stamp - steady) <= self._rounding or not 0 < stamp - self._last <= LONGEST_GAP:
            return steady
        self._anchor, self._anchor_stamp = self._index, stamp
        return stamp
