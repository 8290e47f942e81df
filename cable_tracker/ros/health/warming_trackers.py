"""Hears on /diagnostics which trackers are warming up."""

from __future__ import annotations

import time

from rclpy.node import Node

from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import subscription
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.tracking.status import WARMING_UP

HOLDS = 60.0
"""Time without another message for which a tracker still counts as warming up [s].

The compiler keeps the interpreter to itself at times, and the diagnostics with it.
"""


class WarmingTrackers:
    """Remembers the trackers whose status is WARMING UP.

    Parameters
    ----------
    node : Node
        Subscribes to /diagnostics.
    """

    def __init__(self, node: Node) -> None:
        self._heard: dict[str, float] = {}
        topic = node_topics.DIAGNOSTICS
        subscription(node, topic, self.on_diagnostics, qos.RESULTS, name=topic.global_name)

    def on_diagnostics(self, message: Message) -> None:
        """Take what a node says of its health."""
        for status in message.status:
            name = str(status.hardware_id)
            if str(status.message) == WARMING_UP:
                self._heard[name] = time.monotonic()
            else:
                self._heard.pop(name, None)

    def names(self) -> list[str]:
        """Return the full names of the nodes that are warming up."""
        oldest = time.monotonic() - HOLDS
        return sorted(name for name, since in self._heard.items() if since >= oldest)
