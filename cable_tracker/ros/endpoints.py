"""Publishers and subscriptions of our topics; a topic says of which type its messages are.

And whether the last messages of publishers have reached their readers, so that a node may end.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from cable_tracker.ros.messages.rclpy_messages import message_class
from cable_tracker.sequences.node_topics import NodeTopic

POLL_PERIOD = 0.02
"""Time between two polls [s]."""

LAST_MESSAGE_PATIENCE = 30.0
"""Longest time for the last messages [s]; a reader that has died is forgotten sooner."""


def publisher(
    node: Node,
    topic: NodeTopic,
    profile: QoSProfile,
    *,
    name: str | None = None,
    events: PublisherEventCallbacks | None = None,
) -> Publisher:
    """Return a new publisher of a topic, under its own name in the node's namespace or another."""
    return node.create_publisher(
        message_class(topic.type_name), name or topic.name, profile, event_callbacks=events
    )


def subscription(
    node: Node,
    topic: NodeTopic,
    callback: Callable[..., None],
    profile: QoSProfile,
    *,
    name: str | None = None,
    events: SubscriptionEventCallbacks | None = None,
    raw: bool = False,
) -> Subscription:
    """Return a new subscription of a topic, by its own name or another; `raw`: of CDR bytes."""
    return node.create_subscription(
        message_class(topic.type_name),
        name or topic.name,
        callback,
        profile,
        event_callbacks=events,
        raw=raw,
    )


class LastMessages:
    """Polls whether the last messages have arrived; a blocking wait would hold back signals.

    Parameters
    ----------
    publishers : iterable of Publisher
        Publishers that have sent their last messages.
    """

    def __init__(self, publishers: Iterable[Publisher]) -> None:
        self._publishers = tuple(publishers)
        self._end = time.monotonic() + LAST_MESSAGE_PATIENCE

    def have_arrived(self) -> bool:
        """Tell whether all readers have received them, or the time for that is over."""
        at_once = Duration(seconds=0)
        arrived = all(each.wait_for_all_acked(at_once) for each in self._publishers)
        return arrived or time.monotonic() > self._end
