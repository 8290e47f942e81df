"""A node's own endpoints, and those of other nodes whose quality of service does not fit them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)
from rclpy.subscription import Subscription

from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.qos import endpoint_name
from cable_tracker.sequences.node_topics import NodeTopic

OTHER_POLICIES = (
    "deadline, liveliness or lease duration do not fit: leave these at their defaults there"
)


class WatchedEndpoints:
    """Creates publishers and subscriptions, and names the endpoints that do not match them.

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
            for sentence in _input_mismatches(
                self._node, each.topic_name, each.qos_profile, parameter
            )
        ]
        for each in self.publishers:
            found += _output_mismatches(self._node, each.topic_name, each.qos_profile)
        for sentence in found:
            if sentence not in self._found:
                self._node.get_logger().error(sentence)
        self._found = found
        return "; ".join(found)


def _input_mismatches(node: Node, topic: str, ours: QoSProfile, parameter: str) -> list[str]:
    """Return a sentence for each publisher on a topic that our subscription cannot hear.

    Parameters
    ----------
    node : Node
        The node that subscribes.
    topic : str
        Full name of the topic.
    ours : QoSProfile
        What our subscription requests.
    parameter : str
        The node's parameter that chooses its reliability; empty: none does.
    """
    return [
        f"{endpoint_name(publisher)} publishes {topic}, but"
        f" {_publisher_advice(publisher.qos_profile, ours, parameter)}"
        for publisher in node.get_publishers_info_by_topic(topic)
        if _is_incompatible(publisher.qos_profile, ours)
    ]


def _output_mismatches(node: Node, topic: str, ours: QoSProfile) -> list[str]:
    """Return a sentence for each subscription to a topic that cannot hear our publisher."""
    return [
        f"{endpoint_name(reader)} subscribes to {topic}, but"
        f" {_subscription_advice(ours, reader.qos_profile)}"
        for reader in node.get_subscriptions_info_by_topic(topic)
        if _is_incompatible(ours, reader.qos_profile)
    ]


def _is_incompatible(offered: Any, wanted: Any) -> bool:  # noqa: ANN401
    compatible, _ = qos_check_compatible(offered, wanted)
    return bool(compatible == QoSCompatibility.ERROR)


def _publisher_advice(offered: Any, ours: Any, parameter: str) -> str:  # noqa: ANN401
    """Name the policy of a publisher that our subscription asks too much of, and what to set."""
    if _asks_for_reliable(offered, ours):
        own = f"set {parameter} to best_effort at the node's start, or " if parameter else "set "
        return (
            f"its reliability is best_effort and ours reliable: {own}the publisher's reliability"
            " to reliable"
        )
    if _asks_for_transient_local(offered, ours):
        return "its durability is volatile and ours transient_local: set its to transient_local"
    return OTHER_POLICIES


def _subscription_advice(ours: Any, wanted: Any) -> str:  # noqa: ANN401
    """Name the policy of a subscription that asks our publisher for too much, and what to set."""
    if _asks_for_reliable(ours, wanted):
        return "it asks for reliability reliable: set its reliability to best_effort"
    if _asks_for_transient_local(ours, wanted):
        return "it asks for durability transient_local: set its durability to volatile"
    return OTHER_POLICIES


def _asks_for_reliable(offered: Any, wanted: Any) -> bool:  # noqa: ANN401
    is_offered = offered.reliability != ReliabilityPolicy.BEST_EFFORT
    return bool(not is_offered and wanted.reliability == ReliabilityPolicy.RELIABLE)


def _asks_for_transient_local(offered: Any, wanted: Any) -> bool:  # noqa: ANN401
    is_offered = offered.durability != DurabilityPolicy.VOLATILE
    return bool(not is_offered and wanted.durability == DurabilityPolicy.TRANSIENT_LOCAL)
