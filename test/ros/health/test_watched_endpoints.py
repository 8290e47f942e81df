from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage, Image, JointState

pytestmark = pytest.mark.slow

BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


def told(diagnostics: Callable[..., Any], node: Any) -> dict[str, str]:
    heard = diagnostics(node)
    return dict(heard[-1][1]) if heard else {}


def test_a_camera_that_cannot_be_heard_is_named_with_what_to_set(
    world: Any, diagnostics: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    node = world.tracker(image_reliability="reliable", diagnostics_period=0.1)
    camera = world.me.create_publisher(Image, "image", BEST_EFFORT)
    words = "set image_reliability to best_effort"
    world.spin(lambda: words in told(diagnostics, node).get("QoS mismatch", ""))
    assert f"{world.namespace}/me publishes" in told(diagnostics, node)["QoS mismatch"]
    assert words in capfd.readouterr().err
    world.me.destroy_publisher(camera)
    world.spin(lambda: told(diagnostics, node)["QoS mismatch"] == "")


def test_no_parameter_is_named_for_a_topic_that_has_none(
    world: Any, diagnostics: Callable[..., Any]
) -> None:
    node = world.tracker(diagnostics_period=0.1)
    prior = world.me.create_publisher(PoseWithCovarianceStamped, "initial_state", BEST_EFFORT)
    words = "set the publisher's reliability to reliable"
    world.spin(lambda: words in told(diagnostics, node).get("QoS mismatch", ""))
    assert "image_reliability" not in told(diagnostics, node)["QoS mismatch"]
    world.me.destroy_publisher(prior)


@pytest.mark.parametrize("topic", ["centreline", "cross_track"])
def test_a_reader_that_cannot_hear_us_is_named_with_what_to_set(
    world: Any, diagnostics: Callable[..., Any], topic: str
) -> None:
    node = world.tracker(diagnostics_period=0.1)
    profile = QoSProfile(
        depth=5,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )
    world.me.create_subscription(PoseWithCovarianceStamped, topic, lambda message: None, profile)
    words = f"subscribes to {world.namespace}/{topic}, but it asks for durability"
    world.spin(lambda: words in told(diagnostics, node).get("QoS mismatch", ""))


def test_readers_that_hear_us_are_not_named(world: Any, diagnostics: Callable[..., Any]) -> None:
    node = world.tracker(diagnostics_period=0.1)
    for topic in ("centreline", "state"):
        world.listen(PoseWithCovarianceStamped if topic == "centreline" else JointState, topic)
    readers = f"subscribers of {world.namespace}/state"
    world.spin(lambda: told(diagnostics, node).get(readers, "0") != "0")
    assert told(diagnostics, node)["QoS mismatch"] == ""


def test_a_reader_that_asks_for_a_deadline_is_named(
    world: Any, diagnostics: Callable[..., Any]
) -> None:
    node = world.tracker(diagnostics_period=0.1)
    profile = QoSProfile(depth=5, deadline=Duration(seconds=1.0))
    world.me.create_subscription(JointState, "state", lambda message: None, profile)
    words = f"subscribes to {world.namespace}/state, but deadline, liveliness"
    world.spin(lambda: words in told(diagnostics, node).get("QoS mismatch", ""))


def test_a_topic_of_another_type_is_reported_when_no_message_comes(
    world: Any, namespace: str, domain: int, capfd: pytest.CaptureFixture[str]
) -> None:
    other = Context()
    # A process of its own would be: within one, a topic has one type.
    rclpy.init(args=[], context=other, domain_id=domain)
    camera = Node("camera", context=other, namespace=namespace)
    camera.create_publisher(CompressedImage, "image", 10)
    world.spin(lambda: world.me.count_publishers("image"))
    node = world.tracker(input_timeout=1.0)
    world.spin(lambda: node.count_publishers("image"))
    world.spin(lambda: node.status == "STALE INPUT")
    camera.destroy_node()
    rclpy.try_shutdown(context=other)
    words = "1 publishers there of type sensor_msgs/msg/CompressedImage"
    assert words in capfd.readouterr().err
