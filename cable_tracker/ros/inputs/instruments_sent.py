"""Whether all messages of the instruments have come that a replay has sent before a frame."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial

from rclpy.node import Node

from cable_tracker.node_parameter_tables import RELIABLE
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import subscription
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.node_topics import NodeTopic


class InstrumentsSent:
    """Keeps the newest message of the topic `instruments_sent`, and what was heard.

    Messages are counted as their sender counts them: then it does not matter when the node began to
    listen.

    Parameters
    ----------
    topics : collection of NodeTopic
        Instruments that the node listens to; what a replay says of others does not count.
    """

    def __init__(self, topics: Collection[NodeTopic]) -> None:
        self._names = frozenset(topic.name for topic in topics)
        self._stamp: int | None = None
        self._counts: dict[str, float] = {}
        self._heard: dict[str, int] = {}

    def hear(self, name: str, number: int | None) -> None:
        """Take note of a message of a topic, the sender's `number`th, or one more if None."""
        self._heard[name] = self._heard.get(name, 0) + 1 if number is None else number

    def has_heard(self, name: str) -> bool:
        """Tell whether a message of a topic has come."""
        return name in self._heard

    def subscribe(self, node: Node, reliability: str, on_news: Callable[[], None]) -> None:
        """Listen if the instruments are read reliably; `on_news` is called after each message."""
        if reliability != RELIABLE:
            return
        profile = qos.instrument_input(reliability)
        taken = partial(self._take_and_tell, on_news)
        subscription(node, node_topics.INSTRUMENTS_SENT, taken, profile)

    def _take_and_tell(self, on_news: Callable[[], None], message: Message) -> None:
        self.take(message)
        on_news()

    def take(self, message: Message) -> None:
        """Take how much a replay has sent before a frame."""
        self._stamp = stamp_of(message.header)
        told = zip(message.name, message.position, strict=False)
        counts = {name: count for name, count in told if name in self._names}
        if any(count < self._counts.get(name, 0) for name, count in counts.items()):
            # Another replay, which counts from its own start: what was heard is of the one before.
            for name, count in counts.items():
                if self._heard.get(name, 0) > count:
                    self._heard[name] = 0
        self._counts = counts

    def tells_of(self, stamp: int) -> bool:
        """Tell whether the newest message is about the frame of a time [ns]."""
        return self._stamp == stamp

    def has_come(self) -> bool:
        """Tell whether all of it has come."""
        return all(self._heard.get(name, 0) >= count for name, count in self._counts.items())
