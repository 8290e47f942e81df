"""Whether the last messages of a node have reached their readers, so that it may end."""

from __future__ import annotations

import time
from collections.abc import Iterable

from rclpy.duration import Duration
from rclpy.publisher import Publisher

LOOK_AGAIN = 0.02
"""Time between two looks at whether they have [s]."""

PATIENCE = 30.0
"""Longest time for the last messages [s]; a reader that has died is forgotten sooner."""


class LastMessages:
    """Asked again and again and not waited for: the node must hear signals meanwhile.

    Parameters
    ----------
    publishers : iterable of Publisher
        Publishers that have sent their last messages.
    """

    def __init__(self, publishers: Iterable[Publisher]) -> None:
        self._publishers = tuple(publishers)
        self._end = time.monotonic() + PATIENCE

    def have_arrived(self) -> bool:
        """Tell whether all readers have got them, or will not get them any more."""
        at_once = Duration(seconds=0)
        arrived = all(each.wait_for_all_acked(at_once) for each in self._publishers)
        return arrived or time.monotonic() > self._end
