from __future__ import annotations

from typing import Any

import pytest
from rclpy.node import Node
from sensor_msgs.msg import JointState

from cable_tracker.errors import RosError
from cable_tracker.ros import endpoints, qos
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.process.ros_context import made_node
from cable_tracker.sequences import node_topics


@pytest.mark.parametrize(("name", "told"), [(None, "state"), ("~/other", "me/other")])
def test_the_type_is_that_of_the_topic(world: Any, name: str | None, told: str) -> None:
    heard: list[Any] = []

    def hear(message: Any) -> None:
        heard.append(message)

    sender = publisher(world.me, node_topics.STATE, qos.RESULTS, name=name)
    reader = subscription(world.me, node_topics.STATE, hear, qos.RESULTS, name=name)
    assert sender.topic_name == reader.topic_name == f"{world.namespace}/{told}"
    world.spin(sender.get_subscription_count)
    sender.publish(JointState(name=["offset"]))
    world.spin(lambda: heard)
    assert heard == [JointState(name=["offset"])]


def test_raw_messages_are_bytes(world: Any) -> None:
    heard: list[Any] = []

    def hear(message: bytes) -> None:
        heard.append(message)

    subscription(world.me, node_topics.STATE, hear, qos.RESULTS, raw=True)
    sender = publisher(world.me, node_topics.STATE, qos.RESULTS)
    world.spin(sender.get_subscription_count)
    sender.publish(JointState())
    world.spin(lambda: heard)
    assert isinstance(heard[0], bytes)


def test_a_missing_package_of_messages_is_reported(
    world: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(type_name: str) -> Any:
        package = type_name.partition("/")[0]
        raise ModuleNotFoundError(f"No module named {package!r}", name=package)

    def make(context: Any) -> Node:
        del context
        publisher(world.me, node_topics.MARKERS, qos.RESULTS)
        return world.me

    monkeypatch.setattr(endpoints, "message_class", missing)
    with pytest.raises(RosError, match=r"package is not installed \(visualization_msgs\); run"):
        made_node(make, world.context)
