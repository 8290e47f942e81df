"""Publishers and subscriptions that report endpoints whose quality of service does not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription


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
        self.profiles: dict[Publisher, Any] = {}

    def create(self, kind: type[Any], topic: str, profile: Any) -> Publisher:  # noqa: ANN401
        """Create one."""
        # Without the defaults: the executor looks at each event in every turn.
        events = PublisherEventCallbacks(
            incompatible_qos=self._on_mismatch, use_default_callbacks=False
        )
        publisher = self._node.create_publisher(kind, topic, profile, event_callbacks=events)
        self.profiles[publisher] = profile
        return publisher


def create_watched_subscription(  # noqa: PLR0917
    node: Node,
    kind: type[Any],
    topic: str,
    callback: Callable[[Any], None],
    profile: Any,  # noqa: ANN401
    on_mismatch: Callable[[Any], None],
) -> Subscription:
    """Create a subscription; `on_mismatch` is called when it cannot hear a publisher."""
    events = SubscriptionEventCallbacks(incompatible_qos=on_mismatch, use_default_callbacks=False)
    return node.create_subscription(kind, topic, callback, profile, event_callbacks=events)
