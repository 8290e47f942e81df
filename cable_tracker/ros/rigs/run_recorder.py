"""Base of what listens to a closed loop: messages by stamp, readiness, and commands held back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.context import Context
from rclpy.node import Node

from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import subscription
from cable_tracker.ros.rigs.released_commands import ReleasedCommands
from cable_tracker.ros.rigs.told_readiness import ToldReadiness, is_guidance
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.node_topics import NodeTopic


class RunRecorder(Node):  # type: ignore[misc]
    """Records a run of several nodes.

    Parameters
    ----------
    name : str
        Name of the node.
    context : Context
        rclpy context of this process.
    namespace : str
        Namespace of the nodes that it listens to.

    Attributes
    ----------
    heard : int
        Number of messages received that were to be recorded.
    """

    def __init__(self, name: str, context: Context, namespace: str) -> None:
        super().__init__(name, context=context, namespace=namespace)
        self.heard = 0
        self._told = ToldReadiness()
        self._commands = ReleasedCommands(self)
        subscription(self, node_topics.DIAGNOSTICS, self._on_diagnostics, qos.EVERYTHING)

    def _record(self, topic: NodeTopic, keep: Callable[[int, Message], None]) -> None:
        """Call `keep` with stamp [ns] and message for all that comes on a topic."""

        # A plain function: rclpy wants to see a callback's signature.
        def hear(message: Any) -> None:  # noqa: ANN401
            self.heard += 1
            keep(stamp_of(message.header), message)

        subscription(self, topic, hear, qos.EVERYTHING)

    def _on_diagnostics(self, message: Any) -> None:  # noqa: ANN401
        for status in message.status:
            if is_guidance(status):
                self._note_mode(stamp_of(message.header), str(status.message))
            else:
                self._told.hear(status)

    def _note_mode(self, stamp: int, mode: str) -> None:
        """Take note of the mode that the controller or follower has told of at a stamp [ns]."""
