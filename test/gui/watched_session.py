"""A session on a recording that a test watches."""

import math
import threading

from cable_tracker.tracking.status import WARMING_UP

TIMEOUT = 300.0
"""Longest wait for what a session is to say, on a busy machine, compiling included [s]."""


class Watched:
    """A session with everything that it has said."""

    def __init__(self, session):
        self.session = session
        self.seen = []
        self._changed = threading.Condition()
        session.listen(self._take)

    def _take(self, snapshot):
        with self._changed:
            self.seen.append(snapshot)
            self._changed.notify_all()

    def wait(self, is_reached):
        """Wait until something is so of what was said last, and return that."""
        with self._changed:
            assert self._changed.wait_for(lambda: self._fits(is_reached), TIMEOUT), self.latest
            reached = self.latest
            # The session shows a snapshot before it tells its listeners.
            assert self._changed.wait_for(lambda: self._has_seen(reached), TIMEOUT), reached
        return self.latest

    def _has_seen(self, snapshot):
        return not self.seen or self.seen[-1].number >= snapshot.number

    def _fits(self, is_reached):
        return self.latest is not None and is_reached(self.latest)

    @property
    def latest(self):
        return self.session.latest

    def at(self, frame, after=0):
        """Wait until a frame has been tracked, in a snapshot later than a number."""
        return self.wait(
            lambda now: now.frame == frame and now.row.status != WARMING_UP and now.number > after
        )

    def go_to(self, frame):
        self.session.seek(frame)
        return self.at(frame)

    def play_to_the_end(self):
        """Play as fast as can be, and return what was said about each frame."""
        first = self.at(self.latest.frame if self.latest else 0)
        self.session.set_speed(math.inf)
        self.session.play()
        self.at(self.session.frame_count - 1)
        return {first.frame: first} | {snapshot.frame: snapshot for snapshot in self.seen}
