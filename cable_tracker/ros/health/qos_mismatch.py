"""Endpoints on our topics whose quality of service does not fit, and what to set."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSCompatibility, ReliabilityPolicy, qos_check_compatible

from cable_tracker.ros.qos import endpoint_name


def input_mismatches(node: Node, topic: str, ours: Any) -> list[str]:  # noqa: ANN401
    """Return a sentence for each publisher on a topic that our subscription cannot hear.

    Parameters
    ----------
    node : Node
        The node that subscribes.
    topic : str
        Full name of the topic.
    ours : QoSProfile
        Profile of our subscription.
    """
    return [
        f"{endpoint_name(publisher)} publishes {topic}, but"
        f" {_words(publisher.qos_profile, ours, 'ours')}"
        for publisher in node.get_publishers_info_by_topic(topic)
        if _is_incompatible(publisher.qos_profile, ours)
    ]


def output_mismatches(node: Node, topic: str, ours: Any) -> list[str]:  # noqa: ANN401
    """Return a sentence for each subscription to a topic that cannot hear our publisher."""
    return [
        f"{endpoint_name(reader)} subscribes to {topic}, but"
        f" {_words(ours, reader.qos_profile, 'its')}"
        for reader in node.get_subscriptions_info_by_topic(topic)
        if _is_incompatible(ours, reader.qos_profile)
    ]


def _is_incompatible(offered: Any, wanted: Any) -> bool:  # noqa: ANN401
    compatible, _ = qos_check_compatible(offered, wanted)
    return bool(compatible == QoSCompatibility.ERROR)


def _words(offered: Any, wanted: Any, whose: str) -> str:  # noqa: ANN401
    """Name the policy and what to set. The subscription is the one that asks for too much."""
    if (
        offered.reliability == ReliabilityPolicy.BEST_EFFORT
        and wanted.reliability == ReliabilityPolicy.RELIABLE
    ):
        if whose == "ours":
            return (
                "its reliability is best_effort and ours reliable: set image_reliability to"
                " best_effort at the tracker's start, or the publisher's reliability to reliable"
            )
        return "it asks for reliability reliable: set its reliability to best_effort"
    if (
        offered.durability == DurabilityPolicy.VOLATILE
        and wanted.durability == DurabilityPolicy.TRANSIENT_LOCAL
    ):
        if whose == "ours":
            return "its durability is volatile and ours transient_local: set its to transient_local"
        return "it asks for durability transient_local: set its durability to volatile"
    return "deadline, liveliness or lease duration do not fit: leave these at their defaults there"
