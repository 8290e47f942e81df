"""Holds frames back until the instruments have told of their time."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from typing import Final

from cable_tracker.ros.inputs.image_input import CameraFrame

MOST_HELD: Final = 10
"""Frames held at once: pictures are large. One more sends the oldest on."""


class FrameHold:
    """Keeps frames in the order in which they came, each for at most a given time.

    Parameters
    ----------
    use : callable
        Gets the frames, in the order in which they came.
    is_complete : callable
        Tells whether everything has come that belongs to a stamp [ns].
    pass_over : callable
        Gets a frame instead of `use` that is late by more than its wait while a newer one is due:
        what a tracker has no time for must not delay the rest.

    Attributes
    ----------
    held : deque of (CameraFrame, float)
        Frames that are held, the oldest first, and how long each may wait [s].
    """

    def __init__(
        self,
        use: Callable[[CameraFrame], None],
        is_complete: Callable[[int], bool],
        pass_over: Callable[[CameraFrame], None],
    ) -> None:
        self._use = use
        self._is_complete = is_complete
        self._pass_over = pass_over
        self.held: deque[tuple[CameraFrame, float]] = deque()

    def take(self, frame: CameraFrame, wait: float) -> None:
        """Hold a frame for at most `wait` seconds; one that does not wait sends the others on."""
        self.held.append((frame, wait))
        if len(self.held) > MOST_HELD:
            self._hand_on(1)
        self.release_if_due()

    def seconds_until_due(self) -> float:
        """Return how long the first frame to be late may still wait [s]; infinite without any."""
        now = time.perf_counter()
        return min((frame.arrival + wait - now for frame, wait in self.held), default=math.inf)

    def release_if_due(self) -> None:
        """Hand frames on of which everything has come, or that have waited long enough.

        And those before them: the order counts for more than what the instruments may still say.
        """
        while due := self._count_due():
            self._hand_on(due)

    def _count_due(self) -> int:
        """Return how many frames are due, the last of them by itself."""
        now = time.perf_counter()
        for count in range(len(self.held), 0, -1):
            frame, wait = self.held[count - 1]
            if now - frame.arrival >= wait or self._is_complete(frame.stamp):
                return count
        return 0

    def _hand_on(self, count: int) -> None:
        """Hand on the oldest frames, of which `count` are due."""
        for newer in range(count - 1, -1, -1):
            frame, wait = self.held.popleft()
            is_late = newer and wait and time.perf_counter() - frame.arrival > 2.0 * wait
            (self._pass_over if is_late else self._use)(frame)
