from __future__ import annotations

from typing import Any

import pytest
from rclpy.node import Node

from cable_tracker.errors import RosError
from cable_tracker.ros.process import ros_context
from cable_tracker.ros.process.ros_context import client_node


def named(context: Any) -> Node:
    return Node("one", context=context)


def test_a_node_is_spun_and_ends_with_its_block() -> None:
    calls = []
    with client_node(named) as (node, executor):
        node.create_timer(0.01, lambda: calls.append(1))
        executor.spin_once(timeout_sec=300.0)
        context = node.context
    assert calls and not context.ok()


def test_a_node_that_cannot_be_made_leaves_no_context_behind() -> None:
    contexts: list[Any] = []

    def fail(context: Any) -> Node:
        contexts.append(context)
        raise ValueError("no such node")

    with pytest.raises(ValueError, match="no such node"), client_node(fail):
        pass
    assert not contexts[0].ok()


def test_ros_that_does_not_start_is_an_error_of_ours(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*words: Any, **named: Any) -> None:
        raise RuntimeError("failed to find the middleware")

    monkeypatch.setattr(ros_context.rclpy, "init", fail)
    with (
        pytest.raises(RosError, match=r"ROS does not start.*environment.*the middleware"),
        client_node(named),
    ):
        pass
