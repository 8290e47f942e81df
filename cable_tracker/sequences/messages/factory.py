"""Interface for making messages with one ROS implementation or another.

Functions that pack take a `MessageFactory`: so they serve the nodes, whose messages are rclpy's,
and the recorder without ROS, whose messages are rosbags'. They alone know the fields; a message
package of our own would replace them and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.node_topics import NodeTopic

Message: TypeAlias = Any
"""A message object of rclpy or of rosbags; neither has static types."""

MessageMakers: TypeAlias = dict[NodeTopic, Callable[[], Message]]
"""Topics for which there is a message, and what makes it; a bag holds them in this order."""


class MessageFactory(Protocol):
    """Makes messages of one ROS implementation."""

    def make(self, type_name: str, /, **fields: object) -> Message:
        """Return a message of a type such as ``std_msgs/msg/Header``; other fields are default."""
        ...

    def doubles(self, values: Sequence[float] | FloatArray) -> object:
        """Return the value of a field ``float64[]``."""
        ...

    def octets(self, data: bytes | memoryview) -> object:
        """Return the value of a field ``uint8[]``."""
        ...

    def octet(self, value: int) -> object:
        """Return the value of a field ``byte``."""
        ...
