"""Makes packets of a session's snapshots, as many as browsers can draw and no more.

With them goes the history, the numbers of the last half minute before the frame that is shown.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from enum import IntEnum
from functools import partial
from itertools import islice

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import CableTrackerError, one_line
from cable_tracker.gui.session.session import AnySnapshot, Session, TargetSnapshot
from cable_tracker.gui.tracking.picture_packet import make_packet, without_picture
from cable_tracker.gui.web.frame_channel import FrameChannel
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.status import DISABLED, REFUSED, TrackingStatus

HISTORY_TIME = 30.0
"""Length of the history that is kept [s]."""

RECENT_TIME = 2.0
"""Length of the history that goes with every picture, so that a browser that missed some has no
gaps [s]."""

MOST_ROWS = 4000
"""Largest number of rows of the history."""

STATUSES = (
    TrackingStatus.TRACKING.value,
    TrackingStatus.LOST.value,
    TrackingStatus.INITIALISING.value,
    REFUSED,
    DISABLED,
)
"""The numbers of the statuses; any other is one more."""

WHOLE_EVERY = 50
"""Number of packets of which one brings the whole history."""

RATE_TIME = 2.0
"""Time over which frames per second are counted [s]."""


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
        self._rows: deque[tuple[int, tuple[float, ...]]] = deque(maxlen=MOST_ROWS)

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
        for stamp, row in islice(newest_first, MOST_ROWS):
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


def _nothing() -> None:
    """Listen to no feed."""


class PictureFeed:
    """Takes the newest snapshot whenever some browser can draw one, in a thread of its own.

    The thread of the session only notes a line of numbers for each frame.

    Attributes
    ----------
    channel : FrameChannel
        Channel that sends the packets.
    """

    def __init__(self) -> None:
        self.channel = FrameChannel(self._is_wanted)
        self._condition = threading.Condition()
        self._session: Session | None = None
        self._snapshot: AnySnapshot | None = None
        self._history = TrackingHistory()
        self._arrivals: deque[float] = deque(maxlen=256)
        self._is_fresh = False
        self._has_newcomer = False
        self._closing = False
        self._count = 0
        self._end_listening: Callable[[], None] = _nothing
        self._thread = threading.Thread(target=self._run, name="pictures", daemon=True)
        self._thread.start()

    def watch(self, session: Session) -> None:
        """Take the snapshots of this session from now on, and of no other."""
        self._end_listening()
        with self._condition:
            self._session = session
            self._history = TrackingHistory()
            self._arrivals.clear()
            self._snapshot = None
        self._end_listening = session.listen(partial(self._take, session))
        with self._condition:
            # One that has come meanwhile is newer.
            if self._snapshot is None and session.latest is not None:
                self._take(session, session.latest)

    def close(self) -> None:
        """End the thread."""
        self._end_listening()
        with self._condition:
            self._closing = True
            self._condition.notify_all()
        self._thread.join()

    def _take(self, session: Session, snapshot: AnySnapshot) -> None:
        with self._condition:
            # A session that is no longer watched may be in the midst of telling.
            if session is not self._session:
                return
            self._snapshot = snapshot
            self._history.add(snapshot)
            self._arrivals.append(time.monotonic())
            self._is_fresh = True
            self._condition.notify_all()

    def _is_wanted(self, is_new: bool) -> None:
        with self._condition:
            self._has_newcomer |= is_new
            self._condition.notify_all()

    def _run(self) -> None:
        while True:
            with self._condition:
                self._condition.wait_for(self._has_to_act)
                if self._closing:
                    return
                snapshot = self._snapshot
                assert snapshot is not None
                is_whole = self._has_newcomer or self._count % WHOLE_EVERY == 0
                self._is_fresh = self._has_newcomer = False
                self._count += 1
                history = self._history.table(snapshot.row.stamp, is_whole=is_whole)
                fps = self._rate()
            try:
                packet = make_packet(snapshot, history, is_whole=is_whole, fps=fps)
            except (CableTrackerError, ValueError) as error:
                # The next frame may be as good as any: the thread goes on.
                shown = without_picture(snapshot, f"cannot be shown: {one_line(error)}")
                packet = make_packet(shown, history, is_whole=is_whole, fps=fps)
            self.channel.publish(packet)

    def _has_to_act(self) -> bool:
        is_due = self._is_fresh or self._has_newcomer
        return self._closing or (is_due and self._snapshot is not None and self.channel.is_wanted)

    def _rate(self) -> float | None:
        oldest = time.monotonic() - RATE_TIME
        while self._arrivals and self._arrivals[0] < oldest:
            self._arrivals.popleft()
        if len(self._arrivals) < 3:
            return None
        return (len(self._arrivals) - 1) / (self._arrivals[-1] - self._arrivals[0] or 1.0)
