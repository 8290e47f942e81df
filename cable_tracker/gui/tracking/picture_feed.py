"""Makes packets of a session's snapshots, as many as browsers can draw and no more."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial

from cable_tracker.errors import CableTrackerError, one_line
from cable_tracker.gui.session.session import Session
from cable_tracker.gui.session.snapshot import AnySnapshot
from cable_tracker.gui.tracking.history import TrackingHistory
from cable_tracker.gui.tracking.picture_packet import make_packet, without_picture
from cable_tracker.gui.web.frame_channel import FrameChannel

WHOLE_EVERY = 50
"""Number of packets of which one brings the whole history."""

RATE_TIME = 2.0
"""Time over which frames per second are counted [s]."""


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
