from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from sensor_msgs.msg import JointState

from cable_tracker.ros.rigs.echo_node import ANSWER, EchoNode
from cable_tracker.sequences.messages.cable import read_state


def test_the_echo_answers_with_the_header_of_the_image(
    world: Any, context: Any, namespace: str, image_message: Callable[..., Any]
) -> None:
    node = world.add(EchoNode(context=context, namespace=namespace))
    states = world.listen(JointState, "state")
    centrelines = world.listen(PoseWithCovarianceStamped, "centreline")
    world.spin(lambda: node.count_subscribers(f"{namespace}/state"))
    message = image_message(index=3)
    node.on_image(message)
    world.spin(lambda: states and centrelines)
    assert states[0].header == centrelines[0].header == message.header
    assert read_state(states[0]) == ANSWER
