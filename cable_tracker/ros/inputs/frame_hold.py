"""Holds a frame back until the instruments have told of its time."""

from __future__ import annotations

import time
from collections.abc import Callable

from cable_tracker.ros.inputs.image_input import CameraFrame


class FrameHold:
    """Keeps at most one frame, for at most a given time.

    Parameters
    ----------
    use : callable
        Gets the frames, in the order in which they came.
    is_complete : callable
        Tells whether everything has come that belongs to a stamp [ns].
    """

    def __init__(
        self, use: Callable[[CameraFrame], None], is_complete: Callable[[int], bool]
    ) -> None:
        self._use = use
        self._is_complete = is_complete
        self._frame: CameraFrame | None = None
        self._wait = 0.0

    def take(self, frame: CameraFrame, wait: float) -> None:
        """Hold a frame for at most `wait` seconds; the one before it goes on at once."""
        # The order of the frames counts for more than what the instruments may still say.
        self.release_if_due(at_once=True)
        self._frame, self._wait = frame, wait
        self.release_if_due()

    def release_if_due(self, *, at_once: bool = False) -> None:
        """Hand the frame on if everything has come, or it has waited long enough."""
        frame = self._frame
        if frame is None:
            return
        is_due = at_once or time.perf_counter() - frame.arrival >= self._wait
        if is_due or self._is_complete(frame.stamp):
            self._frame = None
            self._use(frame)
