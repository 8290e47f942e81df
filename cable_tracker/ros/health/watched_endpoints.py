"""A node's own endpoints, watched for those of others whose quality of service does not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.health.qos_mismatch import input_mismatches, output_mismatches
from cable_tracker.sequences.node_topics import NodeTopic


class WatchedEndpoints:
    """Creates publishers and subscriptions, and tells who cannot hear them or be heard by them.

    Without rclpy's own callbacks of events: the executor looks at each event in every turn, and an
    event names no endpoint. Which it is stands in the graph.

    Parameters
    ----------
    node : Node
        Publishes and listens.

    Attributes
    ----------
    publishers : list of Publisher
        All that were created.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.publishers: list[Publisher] = []
        self._subscriptions: list[tuple[Subscription, str]] = []
        self._found: list[str] = []

    def publisher(
        self, topic: NodeTopic, profile: QoSProfile, name: str | None = None
    ) -> Publisher:
        """Create a publisher; without a name under that of the topic."""
        events = PublisherEventCallbacks(use_default_callbacks=False)
        created = publisher(self._node, topic, profile, name=name, events=events)
        self.publishers.append(created)
        return created

    def subscription(
        self,
        topic: NodeTopic,
        callback: Callable[..., None],
        profile: QoSProfile,
        *,
        name: str | None = None,
        raw: bool = False,
        on_lost: Callable[[Any], None] | None = None,
        reliability_parameter: str = "",
    ) -> Subscription:
        """Create a subscription, as `endpoints.subscription` does.

        Parameters
        ----------
        on_lost : callable or None
            Takes the middleware's event that messages were lost on the way.
        reliability_parameter : str
            The node's parameter that chooses the reliability; empty: none does.
        """
        events = SubscriptionEventCallbacks(message_lost=on_lost, use_default_callbacks=False)
        created = subscription(
            self._node, topic, callback, profile, name=name, events=events, raw=raw
        )
        self._subscriptions.append((created, reliability_parameter))
        return created

    def mismatches(self) -> str:
        """Return in one line who does not fit now, and what to set; log what is new of it."""
        found = [
            sentence
            for each, parameter in self._subscriptions
            for sentence in input_mismatches(
                self._node, each.topic_name, each.qos_profile, parameter
            )
        ]
        for each in self.publishers:
            found += output_mismatches(self._node, each.topic_name, each.qos_profile)
        for sentence in found:
            if sentence not in self._found:
                self._node.get_logger().error(sentence)
        self._found = found
        return "; ".join(found)
