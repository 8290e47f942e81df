"""Whether the last messages of a node have reached their readers, so that it may end."""

from __future__ import annotations

import time
from collections.abc import Iterable

from rclpy.duration import Duration
from rclpy.publisher import Publisher

POLL_PERIOD = 0.02
"""Time between two polls [s]."""

PATIENCE = 30.0
"""Longest time for the last messages [s]; a reader that has died is forgotten sooner."""


class LastMessages:
    """Polls whether the last messages have arrived; a blocking wait would hold back signals.

    Parameters
    ----------
    publishers : iterable of Publisher
        Publishers that have sent their last messages.
    """

    def __init__(self, publishers: Iterable[Publisher]) -> None:
        self._publishers = tuple(publishers)
        self._end = time.monotonic() + PATIENCE

    def have_arrived(self) -> bool:
        """Tell whether all readers have received them, or the time for that is over."""
        at_once = Duration(seconds=0)
        arrived = all(each.wait_for_all_acked(at_once) for each in self._publishers)
        return arrived or time.monotonic() > self._end
