"""Publishers and subscriptions of our topics; a topic says of which type its messages are."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from cable_tracker.ros.messages.rclpy_messages import message_class
from cable_tracker.sequences.node_topics import NodeTopic


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
