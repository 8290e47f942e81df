"""Counts of the instruments' messages that a replay has sent before a frame."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from rclpy.node import Node
from sensor_msgs.msg import JointState

from cable_tracker.ros import qos
from cable_tracker.ros.inputs.callbacks import followed_by
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.node_topics import NodeTopic

RELIABLE = "reliable"


class InstrumentsSent:
    """Keeps the newest message of the topic `instruments_sent`.

    Parameters
    ----------
    topics : collection of NodeTopic
        Instruments that the node listens to; what a replay says of others does not count.
    """

    def __init__(self, topics: Collection[NodeTopic]) -> None:
        self._names = frozenset(topic.name for topic in topics)
        self._stamp: int | None = None
        self._counts: dict[str, float] = {}

    def subscribe(self, node: Node, reliability: str, on_news: Callable[[], None]) -> None:
        """Listen if the instruments are read reliably; `on_news` is called after each message."""
        if reliability == RELIABLE:
            node.create_subscription(
                JointState,
                node_topics.INSTRUMENTS_SENT.name,
                followed_by(self.take, on_news),
                qos.instrument_input(reliability),
            )

    def take(self, message: Message) -> None:
        """Take how much a replay has sent before a frame."""
        self._stamp = stamp_of(message.header)
        told = zip(message.name, message.position, strict=False)
        self._counts = {name: count for name, count in told if name in self._names}

    def tells_of(self, stamp: int) -> bool:
        """Tell whether the newest message is about the frame of a time [ns]."""
        return self._stamp == stamp

    def has_come(self, heard: Mapping[str, int]) -> bool:
        """Tell whether all of it has come, by how many messages of each instrument were heard."""
        return all(heard.get(name, 0) >= count for name, count in self._counts.items())
