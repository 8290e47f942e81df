"""Publishers and subscriptions that report endpoints whose quality of service does not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.sequences.node_topics import NodeTopic


class WatchedPublishers:
    """Creates publishers that report unfit subscriptions, and remembers their profiles.

    Parameters
    ----------
    node : Node
        Publishes.
    on_mismatch : callable
        Called when a subscription is found that cannot hear us.

    Attributes
    ----------
    profiles : dict of Publisher to QoSProfile
        All that were created.
    """

    def __init__(self, node: Node, on_mismatch: Callable[[Any], None]) -> None:
        self._node = node
        self._on_mismatch = on_mismatch
        self.profiles: dict[Publisher, QoSProfile] = {}

    def create(self, topic: NodeTopic, profile: QoSProfile, name: str | None = None) -> Publisher:
        """Create one; without a name under that of the topic."""
        # Without the defaults: the executor looks at each event in every turn.
        events = PublisherEventCallbacks(
            incompatible_qos=self._on_mismatch, use_default_callbacks=False
        )
        created = publisher(self._node, topic, profile, name=name, events=events)
        self.profiles[created] = profile
        return created


def create_watched_subscription(
    node: Node,
    topic: NodeTopic,
    callback: Callable[[Any], None],
    profile: QoSProfile,
    on_mismatch: Callable[[Any], None],
    *,
    name: str | None = None,
) -> Subscription:
    """Create a subscription; `on_mismatch` is called when it cannot hear a publisher."""
    events = SubscriptionEventCallbacks(incompatible_qos=on_mismatch, use_default_callbacks=False)
    return subscription(node, topic, callback, profile, name=name, events=events)
