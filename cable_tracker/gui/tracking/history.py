"""The last half minute before the frame that is shown."""

from __future__ import annotations

import math
from collections import deque
from enum import IntEnum
from itertools import islice

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import CableState
from cable_tracker.gui.session.snapshot import AnySnapshot, TargetSnapshot
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.status import DISABLED, REFUSED, TrackingStatus

HISTORY_TIME = 30.0
"""Length of the history that is kept [s]."""

RECENT_TIME = 2.0
"""Length of the history that goes with every picture, so that a browser that missed some has no
gaps [s]."""

LARGEST_LENGTH = 4000

STATUSES = (
    TrackingStatus.TRACKING.value,
    TrackingStatus.LOST.value,
    TrackingStatus.INITIALISING.value,
    REFUSED,
    DISABLED,
)
"""The numbers of the statuses; any other is one more."""


class HistoryColumn(IntEnum):
    """Columns of the table that the browser gets; the same as in history_plot.js.

    First and second are the components of the state that `Subject.lanes` names.
    """

    TIME = 0
    FIRST = 1
    SECOND = 2
    FIRST_SIGMA = 3
    SECOND_SIGMA = 4
    PRESENCE = 5
    STATUS = 6
    N_EFF = 7
    MS = 8
    TRUE_FIRST = 9
    TRUE_SECOND = 10


class TrackingHistory:
    """Numbers of the frames up to the newest; going back takes away those that come after."""

    def __init__(self) -> None:
        self._rows: deque[tuple[int, tuple[float, ...]]] = deque(maxlen=LARGEST_LENGTH)

    def add(self, snapshot: AnySnapshot) -> None:
        """Add a frame."""
        while self._rows and self._rows[-1][0] >= snapshot.stamp:
            self._rows.pop()
        oldest = snapshot.stamp - HISTORY_TIME * NANOSECONDS
        while self._rows and self._rows[0][0] < oldest:
            self._rows.popleft()
        self._rows.append((snapshot.stamp, _row_of(snapshot)))

    def table(self, now: int, *, is_whole: bool) -> FloatArray:
        """Return the rows, all or those of the last two seconds, shape (N, 11).

        Parameters
        ----------
        now : int
            Times are given relative to this [ns]; later rows are left out.
        is_whole : bool
            Whether all are wanted.
        """
        oldest = -math.inf if is_whole else now - RECENT_TIME * NANOSECONDS
        newest_first = ((stamp, row) for stamp, row in reversed(self._rows) if stamp <= now)
        rows = []
        for stamp, row in islice(newest_first, LARGEST_LENGTH):
            if stamp < oldest:
                break
            rows.append(((stamp - now) / NANOSECONDS, *row))
        return np.array(rows[::-1], dtype=np.float64).reshape(-1, len(HistoryColumn))


def _row_of(snapshot: AnySnapshot) -> tuple[float, ...]:
    values, sigmas, truths = _lanes(snapshot)
    status = STATUSES.index(snapshot.status) if snapshot.status in STATUSES else len(STATUSES)
    return (
        *values,
        *sigmas,
        snapshot.presence if snapshot.presence is not None else math.nan,
        float(status),
        snapshot.n_eff if snapshot.n_eff is not None else math.nan,
        snapshot.ms if snapshot.ms is not None else math.nan,
        *truths,
    )


Pair = tuple[float, float]

UNKNOWN: Pair = (math.nan, math.nan)


def _lanes(snapshot: AnySnapshot) -> tuple[Pair, Pair, Pair]:
    """Return the two components that are shown, their sigmas and their truths; NaN if unknown."""
    if isinstance(snapshot, TargetSnapshot):
        return _pair(snapshot.state), _pair(snapshot.sigma), UNKNOWN
    return (
        _of_cable(snapshot.state),
        UNKNOWN if snapshot.sigma is None else _in_degrees(snapshot.sigma),
        _of_cable(snapshot.truth),
    )


def _pair(values: FloatArray | None) -> Pair:
    return UNKNOWN if values is None else (float(values[0]), float(values[1]))


def _in_degrees(values: FloatArray) -> Pair:
    return float(values[0]), math.degrees(values[1])


def _of_cable(state: CableState | None) -> Pair:
    return UNKNOWN if state is None else (state.distance, math.degrees(state.angle))
