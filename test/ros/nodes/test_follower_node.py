from __future__ import annotations

from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
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


def test_a_frame_without_a_claim_changes_nothing_and_after_some_it_remembers(
    world: Any, header: Any
) -> None:
    commands = world.listen(Twist, "cmd_vel")
    node = world.follower(lockstep=True)
    tell(node, header(0), 4.0)
    tell(node, header(1), None)
    world.spin(lambda: len(commands) == 2)
    assert commands[1] == commands[0]
    assert node.mode is FollowMode.FOLLOWING
    tell(node, header(20), None)
    world.spin(lambda: len(commands) == 3)
    assert node.mode is FollowMode.REMEMBERING


def report(header: Any, **facts: str) -> DiagnosticArray:
    """What the target tracker reports of one frame."""
    values = [KeyValue(key=key, value=value) for key, value in facts.items()]
    return DiagnosticArray(header=header, status=[DiagnosticStatus(values=values)])


def claims(node: Any, header: Any) -> None:
    node.on_state(JointState(header=header, position=[0.0] * 4))


def test_in_lockstep_a_place_that_is_announced_is_waited_for(world: Any, header: Any) -> None:
    commands = world.listen(Twist, "cmd_vel")
    node = world.follower(lockstep=True, settle_time=60.0)
    node.on_report(report(header(0), x="4.0"))
    claims(node, header(0))
    world.pass_time(0.2)
    assert not commands
    tell(node, header(1), 4.0)
    place = PoseWithCovarianceStamped(header=header(0))
    place.pose.pose.position.x = 4.0
    node.on_relative_pose(place)
    world.spin(lambda: len(commands) == 2)
    assert commands[0].linear.x > 0.0


def test_in_lockstep_a_place_that_is_withheld_is_not_waited_for(world: Any, header: Any) -> None:
    commands = world.listen(Twist, "cmd_vel")
    node = world.follower(lockstep=True, settle_time=60.0)
    claims(node, header(0))
    world.pass_time(0.2)
    assert not commands
    node.on_report(report(header(0), why_not="no camera calibration"))
    # Long before the time to settle is over.
    world.spin(lambda: commands, 30.0)


def test_a_silent_tracker_stops_the_vehicle(world: Any, header: Any) -> None:
    commands = world.listen(Twist, "cmd_vel")
    node = world.follower(state_timeout=0.2)
    tell(node, header(0), 4.0)
    world.spin(lambda: len(commands) == 2)
    assert commands[0].linear.x > 0.0
    assert commands[1].linear.x == pytest.approx(0.0)
