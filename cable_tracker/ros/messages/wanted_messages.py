"""Messages that are made only where a node listens."""

from __future__ import annotations

from collections.abc import Mapping

from rclpy.publisher import Publisher

from cable_tracker.sequences.messages.factory import MessageMakers
from cable_tracker.sequences.node_topics import NodeTopic


def publish_wanted(
    publishers: Mapping[NodeTopic, Publisher], makers: MessageMakers, *topics: NodeTopic
) -> None:
    """Publish on some topics, in their order, what there is for them and is subscribed to."""
    for topic in topics:
        if topic in makers and publishers[topic].get_subscription_count():
            publishers[topic].publish(makers[topic]())
