"""Endpoints on our topics whose quality of service does not fit, and what to set."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

from cable_tracker.ros.qos import endpoint_name

OTHERS = "deadline, liveliness or lease duration do not fit: leave these at their defaults there"


def input_mismatches(node: Node, topic: str, ours: QoSProfile, parameter: str) -> list[str]:
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
        f" {_words_on_publisher(publisher.qos_profile, ours, parameter)}"
        for publisher in node.get_publishers_info_by_topic(topic)
        if _is_incompatible(publisher.qos_profile, ours)
    ]


def output_mismatches(node: Node, topic: str, ours: QoSProfile) -> list[str]:
    """Return a sentence for each subscription to a topic that cannot hear our publisher."""
    return [
        f"{endpoint_name(reader)} subscribes to {topic}, but"
        f" {_words_on_reader(ours, reader.qos_profile)}"
        for reader in node.get_subscriptions_info_by_topic(topic)
        if _is_incompatible(ours, reader.qos_profile)
    ]


def _is_incompatible(offered: Any, wanted: Any) -> bool:  # noqa: ANN401
    compatible, _ = qos_check_compatible(offered, wanted)
    return bool(compatible == QoSCompatibility.ERROR)


def _words_on_publisher(offered: Any, ours: Any, parameter: str) -> str:  # noqa: ANN401
    """Name the policy of a publisher that our subscription asks too much of, and what to set."""
    if _asks_for_reliable(offered, ours):
        own = f"set {parameter} to best_effort at the node's start, or " if parameter else "set "
        return (
            f"its reliability is best_effort and ours reliable: {own}the publisher's reliability"
            " to reliable"
        )
    if _asks_for_transient_local(offered, ours):
        return "its durability is volatile and ours transient_local: set its to transient_local"
    return OTHERS


def _words_on_reader(ours: Any, wanted: Any) -> str:  # noqa: ANN401
    """Name the policy of a subscription that asks our publisher for too much, and what to set."""
    if _asks_for_reliable(ours, wanted):
        return "it asks for reliability reliable: set its reliability to best_effort"
    if _asks_for_transient_local(ours, wanted):
        return "it asks for durability transient_local: set its durability to volatile"
    return OTHERS


def _asks_for_reliable(offered: Any, wanted: Any) -> bool:  # noqa: ANN401
    is_offered = offered.reliability != ReliabilityPolicy.BEST_EFFORT
    return bool(not is_offered and wanted.reliability == ReliabilityPolicy.RELIABLE)


def _asks_for_transient_local(offered: Any, wanted: Any) -> bool:  # noqa: ANN401
    is_offered = offered.durability != DurabilityPolicy.VOLATILE
    return bool(not is_offered and wanted.durability == DurabilityPolicy.TRANSIENT_LOCAL)
