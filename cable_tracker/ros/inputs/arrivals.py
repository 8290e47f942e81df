"""Message information of the middleware: times of waiting, and missing messages."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from cable_tracker.stamps import NANOSECONDS

LONGEST_WAIT = 60.0
"""A message that seems to have waited longer has not: the clock was set meanwhile [s]."""


def seconds_waited(info: Mapping[str, Any], now: int) -> float:
    """Return how long a message has lain in the middleware's queue [s]; 0 where it is not known.

    Parameters
    ----------
    info : mapping
        Message info from rclpy: `received_timestamp` and sequence number.
    now : int
        The system's time [ns].
    """
    received = info.get("received_timestamp") or 0
    waited = (now - int(received)) / NANOSECONDS
    return waited if received and 0.0 <= waited <= LONGEST_WAIT else 0.0


def moment_of_arrival(info: Mapping[str, Any]) -> float:
    """Return when a message reached this process, on the clock of `time.perf_counter` [s]."""
    return time.perf_counter() - seconds_waited(info, time.time_ns())


class GapCounter:
    """Counts frames that a publisher sent and that never reached the node.

    The middleware numbers what a publisher sends. Which publisher sent a message is not told: with
    several on the topic the numbers say nothing.
    """

    def __init__(self) -> None:
        self._last: int | None = None

    def missing(self, info: Mapping[str, Any], count_publishers: Callable[[], int]) -> int:
        """Return how many messages lie between this one and the one before.

        Parameters
        ----------
        info : mapping
            Message info from rclpy: `received_timestamp` and sequence number.
        count_publishers : callable
            Returns how many there are on the topic; called only where a number is missing.
        """
        number = info.get("publication_sequence_number")
        last, self._last = self._last, number
        if number is None or last is None:
            return 0
        # Where the numbers go back, the publisher is a new one.
        gap = max(int(number) - int(last) - 1, 0)
        return gap if gap and count_publishers() == 1 else 0
