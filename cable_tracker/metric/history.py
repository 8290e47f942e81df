"""Measurements with stamps, looked up at other times."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import deque
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.succession import LATE

KEPT = 2048
"""Measurements kept: two seconds of an imu at 1 kHz. In a recording those are known, too, that came
a little after the picture."""


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """A measurement looked up.

    Attributes
    ----------
    values : FloatArray
        Shape (k,).
    age : float
        How long before the time asked for the nearest earlier measurement was made [s]; 0 if a
        later one is known as well, for the value is interpolated then.
    nearest : float
        How far the nearest measurement is from the time asked for, earlier or later [s].
    """

    values: FloatArray
    age: float
    nearest: float


class History:
    """The last measurements of one instrument, in the order of their stamps."""

    def __init__(self) -> None:
        self._stamps: deque[int] = deque(maxlen=KEPT)
        self._values: deque[FloatArray] = deque(maxlen=KEPT)

    def __len__(self) -> int:
        return len(self._stamps)

    def __deepcopy__(self, _memo: dict[int, object]) -> History:
        # Measurements never change: copies share them.
        other = History()
        other._stamps, other._values = self._stamps.copy(), self._values.copy()
        return other

    @property
    def last_values(self) -> FloatArray | None:
        """The newest measurement, shape (k,); None before any."""
        return self._values[-1] if self._values else None

    def add(self, stamp: int, values: FloatArray) -> None:
        """Take a measurement, shape (k,).

        A clock that jumps back makes everything before worthless. A stamp seen already, or a little
        older than the newest one, replaces nothing: that message was overtaken on its way.
        """
        if self._stamps and stamp <= self._stamps[-1]:
            if self._stamps[-1] - stamp <= LATE * NANOSECONDS:
                return
            self.clear()
        self._stamps.append(stamp)
        self._values.append(values)

    def clear(self) -> None:
        """Forget everything."""
        self._stamps.clear()
        self._values.clear()

    def at(self, stamp: int) -> Reading | None:
        """Return the measurement at a time [ns], interpolated; None before the first.

        After the last measurement its value is held, and `age` says for how long.
        """
        after = bisect_right(self._stamps, stamp)
        if after == 0:
            return None
        before_stamp, before = self._stamps[after - 1], self._values[after - 1]
        if after == len(self._stamps) or stamp == before_stamp:
            age = (stamp - before_stamp) / NANOSECONDS
            return Reading(before, age, age)
        share = (stamp - before_stamp) / (self._stamps[after] - before_stamp)
        # Between two infinite values the result is NaN, which callers check for.
        with np.errstate(invalid="ignore"):
            value = before + share * (self._values[after] - before)
        nearest = min(stamp - before_stamp, self._stamps[after] - stamp)
        return Reading(value, 0.0, nearest / NANOSECONDS)

    def around(self, stamp: int) -> list[FloatArray]:
        """Return the one or two measurements that `at` interpolates between, shape (k,) each."""
        after = bisect_right(self._stamps, stamp)
        if after and self._stamps[after - 1] == stamp:
            return [self._values[after - 1]]
        return [
            self._values[place] for place in (after - 1, after) if 0 <= place < len(self._stamps)
        ]

    def between(self, start: int, end: int) -> list[tuple[int, FloatArray]]:
        """Return the measurements with start <= stamp < end, stamps [ns] and values."""
        first, last = bisect_left(self._stamps, start), bisect_left(self._stamps, end)
        return [(self._stamps[place], self._values[place]) for place in range(first, last)]

    def is_frozen(self, count: int, until: int) -> bool:
        """Tell whether the last `count` measurements up to a stamp [ns] are the same bit for bit.

        No instrument under water measures the same number again and again.
        """
        end = bisect_right(self._stamps, until)
        if end < count:
            return False
        last = [self._values[place] for place in range(end - count, end)]
        return all(np.array_equal(values, last[0]) for values in last)
