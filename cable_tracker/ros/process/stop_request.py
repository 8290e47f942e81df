"""Signals that ask a process to stop. Imports no ROS, so that it is ready before ROS is loaded."""

from __future__ import annotations

import signal
from types import FrameType


class StopRequest:
    """Whether SIGINT or SIGTERM has come."""

    def __init__(self) -> None:
        self.requested = False

    def __call__(self, signal_number: int, frame: FrameType | None) -> None:
        """Take note of a signal."""
        self.requested = True


def stop_on_signals() -> StopRequest:
    """Install handlers for SIGINT and SIGTERM in this process."""
    stop = StopRequest()
    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)
    return stop
