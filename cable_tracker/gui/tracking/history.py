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
        stamp = snapshot.row.stamp
        while self._rows and self._rows[-1][0] >= stamp:
            self._rows.pop()
        oldest = stamp - HISTORY_TIME * NANOSECONDS
        while self._rows and self._rows[0][0] < oldest:
            self._rows.popleft()
        self._rows.append((stamp, _row_of(snapshot)))

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
    row = snapshot.row
    values, sigmas, truths = _lanes(snapshot)
    status = STATUSES.index(row.status) if row.status in STATUSES else len(STATUSES)
    return (
        *values,
        *sigmas,
        row.presence if row.presence is not None else math.nan,
        float(status),
        row.n_eff if row.n_eff is not None else math.nan,
        row.ms if row.ms is not None else math.nan,
        *truths,
    )


Pair = tuple[float, float]

UNKNOWN: Pair = (math.nan, math.nan)


def _lanes(snapshot: AnySnapshot) -> tuple[Pair, Pair, Pair]:
    """Return the two components that are shown, their sigmas and their truths; NaN if unknown."""
    if isinstance(snapshot, TargetSnapshot):
        claim = snapshot.row.claim
        if claim is None:
            return UNKNOWN, UNKNOWN, UNKNOWN
        return (claim.state[0], claim.state[1]), (claim.sigma[0], claim.sigma[1]), UNKNOWN
    sigma = snapshot.row.sigma
    return (
        _of_cable(snapshot.row.state),
        UNKNOWN if sigma is None else (sigma[0], math.degrees(sigma[1])),
        _of_cable(snapshot.truth),
    )


def _of_cable(state: CableState | None) -> Pair:
    return UNKNOWN if state is None else (state.distance, math.degrees(state.angle))
