from __future__ import annotations

from typing import Any

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from sensor_msgs.msg import JointState

from cable_tracker.example_controller.target_follower import FollowMode


def tell(node: Any, header: Any, ahead: float | None, left: float = 0.0) -> None:
    """Hand a node what the target tracker says of one frame."""
    state = JointState(header=header, name=["x", "y", "size", "angle"])
    if ahead is not None:
        pose = PoseWithCovarianceStamped(header=header)
        pose.pose.pose.position.x, pose.pose.pose.position.y = ahead, left
        node.on_relative_pose(pose)
        state.position = [0.0] * 4
    node.on_state(state)


def test_every_state_is_answered_with_a_command(world: Any, header: Any) -> None:
    commands = world.listen(Twist, "cmd_vel")
    node = world.follower(lockstep=True)
    for index in range(3):
        tell(node, header(index), 4.0, 0.5)
    world.spin(lambda: len(commands) == 3)
    assert commands[-1].linear.x > 0.0
    assert commands[-1].angular.z > 0.0
    assert node.mode is FollowMode.FOLLOWING


def test_without_a_claim_it_remembers(world: Any, header: Any) -> None:
    commands = world.listen(Twist, "cmd_vel")
    node = world.follower(lockstep=True)
    tell(node, header(0), 4.0)
    tell(node, header(1), None)
    world.spin(lambda: len(commands) == 2)
    assert node.mode is FollowMode.REMEMBERING


def test_a_silent_tracker_stops_the_vehicle(world: Any, header: Any) -> None:
    commands = world.listen(Twist, "cmd_vel")
    node = world.follower(state_timeout=0.2)
    tell(node, header(0), 4.0)
    world.spin(lambda: len(commands) == 2)
    assert commands[0].linear.x > 0.0
    assert commands[1].linear.x == pytest.approx(0.0)
