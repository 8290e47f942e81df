"""Commands on their way through a rig's recorder, which lets a lockstep go on when all is kept."""

from __future__ import annotations

from collections import deque
from typing import Final

from rclpy.node import Node

from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message

COMMAND: Final = node_topics.COMMAND.name
RELEASED: Final = "recorded_cmd_vel"
"""Topic on which a simulator in lockstep awaits commands."""

KEPT = 100
"""Commands that may wait. In lockstep it is one or two; in real time nothing takes them."""


class ReleasedCommands:
    """Holds each command back until all about its frame has been recorded.

    The nodes of a loop drive each other. A recorder that only listened could fall behind them by
    more messages than they keep for it, where the machine gives it no processor for a while.

    Parameters
    ----------
    node : Node
        The recorder.

    Attributes
    ----------
    heard : int
        Number of commands received.
    """

    def __init__(self, node: Node) -> None:
        self.heard = 0
        self._released = 0
        self._waiting: deque[Message] = deque(maxlen=KEPT)
        self._publisher = publisher(node, node_topics.COMMAND, qos.RESULTS, name=RELEASED)
        subscription(node, node_topics.COMMAND, self._hear, qos.EVERYTHING)

    def _hear(self, message: Message) -> None:
        self.heard += 1
        self._waiting.append(message)

    def release(self, recorded: int) -> None:
        """Hand on what has waited long enough.

        Parameters
        ----------
        recorded : int
            Frames of which all has been recorded so far; each has one command.
        """
        while (
            self._waiting and self._released < recorded and self._publisher.get_subscription_count()
        ):
            self._publisher.publish(self._waiting.popleft())
            self._released += 1
