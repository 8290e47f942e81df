"""The last half minute before the frame that is shown."""

from __future__ import annotations

import math
from collections import deque
from enum import IntEnum
from itertools import islice

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.gui.session import Snapshot
from cable_tracker.sequences.stamps import NANOSECONDS

HISTORY_TIME = 30.0
"""So much is kept [s]."""

RECENT_TIME = 2.0
"""So much goes with every picture, so that a browser that missed some has no gaps [s]."""

LARGEST_LENGTH = 4000

STATUSES = ("TRACKING", "LOST", "INITIALISING", "REFUSED", "DISABLED")
"""The numbers of the statuses; any other is one more."""


class HistoryColumn(IntEnum):
    """Columns of the table that the browser gets; the same as in browser/history_plot.js."""

    TIME = 0
    DISTANCE = 1
    ANGLE = 2
    DISTANCE_SIGMA = 3
    ANGLE_SIGMA = 4
    PRESENCE = 5
    STATUS = 6
    N_EFF = 7
    MS = 8
    TRUE_DISTANCE = 9
    TRUE_ANGLE = 10


class TrackingHistory:
    """Numbers of the frames up to the newest; going back takes away those that come after."""

    def __init__(self) -> None:
        self._rows: deque[tuple[int, tuple[float, ...]]] = deque(maxlen=LARGEST_LENGTH)

    def add(self, snapshot: Snapshot) -> None:
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


def _row_of(snapshot: Snapshot) -> tuple[float, ...]:
    state, sigma, truth = snapshot.state, snapshot.sigma, snapshot.truth
    status = STATUSES.index(snapshot.status) if snapshot.status in STATUSES else len(STATUSES)
    return (
        state.distance if state is not None else math.nan,
        math.degrees(state.angle) if state is not None else math.nan,
        float(sigma[0]) if sigma is not None else math.nan,
        math.degrees(sigma[1]) if sigma is not None else math.nan,
        snapshot.presence if snapshot.presence is not None else math.nan,
        float(status),
        snapshot.n_eff if snapshot.n_eff is not None else math.nan,
        snapshot.ms if snapshot.ms is not None else math.nan,
        truth.distance if truth is not None else math.nan,
        math.degrees(truth.angle) if truth is not None else math.nan,
    )
