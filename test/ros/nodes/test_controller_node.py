from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovarianceStamped, Quaternion, Twist
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Log
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from cable_tracker.example_controller.command import Command
from cable_tracker.example_controller.controller import CONFIRMATIONS, Mode
from cable_tracker.ros.nodes import guidance_node
from cable_tracker.ros.nodes.controller_node import ControllerNode
from cable_tracker.ros.process.ros_context import started_context

PATIENT = {"settle_time": 60.0, "state_timeout": 60.0}


class Tracker:
    """Says what a tracker would say about frames, 0.1 s apart."""

    def __init__(self, world: Any) -> None:
        self._world = world
        self._publishers = {
            topic: world.me.create_publisher(kind, topic, 10)
            for kind, topic in (
                (JointState, "state"),
                (PoseWithCovarianceStamped, "cross_track"),
                (Odometry, "odometry"),
                (DiagnosticArray, "tracker/frame_report"),
            )
        }
        self.commands = world.listen(Twist, "cmd_vel")
        self._frame = 0

    def is_heard(self) -> None:
        self._world.spin(
            lambda: all(
                each.get_subscription_count()
                for topic, each in self._publishers.items()
                if topic != "tracker/frame_report"
            )
        )

    def reports_are_heard(self) -> None:
        self._world.spin(self._publishers["tracker/frame_report"].get_subscription_count)

    def _header(self) -> Header:
        seconds, tenths = divmod(self._frame, 10)
        return Header(stamp=Time(sec=1 + seconds, nanosec=100_000_000 * tenths))

    def next_frame(self) -> None:
        self._frame += 1

    def says_state(self, *, claims: bool) -> None:
        position = [0.0, 0.0, 30.0, 0.0] if claims else []
        self._publishers["state"].publish(JointState(header=self._header(), position=position))

    def says_cross_track(self, offset: float, heading: float) -> None:
        message = PoseWithCovarianceStamped(header=self._header())
        message.pose.pose.position.y = offset
        message.pose.pose.orientation.z = math.sin(heading / 2)
        message.pose.pose.orientation.w = math.cos(heading / 2)
        self._publishers["cross_track"].publish(message)

    def reports(self, message: str = "", **facts: str) -> None:
        values = [KeyValue(key=key, value=value) for key, value in facts.items()]
        status = [DiagnosticStatus(message=message, values=values)]
        report = DiagnosticArray(header=self._header(), status=status)
        self._publishers["tracker/frame_report"].publish(report)

    def says_odometry(self) -> None:
        self._publishers["odometry"].publish(Odometry(header=self._header()))

    def tells(self, offset: float, heading: float = 0.0, frames: int = CONFIRMATIONS) -> None:
        for _ in range(frames):
            count = len(self.commands)
            self.next_frame()
            self.says_odometry()
            self.says_cross_track(offset, heading)
            self.says_state(claims=True)
            self._world.spin(lambda count=count: len(self.commands) > count)
            self._world.empty_queues()

    def loses(self, frames: int) -> None:
        for _ in range(frames):
            count = len(self.commands)
            self.next_frame()
            self.says_odometry()
            self.says_state(claims=False)
            self._world.spin(lambda count=count: len(self.commands) > count)

    def refuses(self) -> None:
        self.next_frame()
        self.says_odometry()
        self.reports("REFUSED")
        self._world.empty_queues()
        self.says_state(claims=False)
        self._world.empty_queues()


@pytest.fixture
def tracker(world: Any) -> Tracker:
    return Tracker(world)


@pytest.fixture
def start(world: Any, tracker: Tracker) -> Callable[..., ControllerNode]:
    """Make a controller that hears the tracker, and waits long for what it misses."""

    def start(**settings: Any) -> ControllerNode:
        node = world.controller(**{**PATIENT, **settings})
        tracker.is_heard()
        return node

    return start


@pytest.fixture
def statuses(diagnostics: Callable[..., list[Any]]) -> Callable[..., list[str]]:
    """What the diagnostics of a node have said so far."""
    return lambda node: [words for words, _ in diagnostics(node)]


@pytest.fixture
def no_patience_for_reports(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guidance_node, "REPORT_PATIENCE", 0.2)


def warnings_of_missing_reports(world: Any, tracker: Tracker, logs: list[Any]) -> list[str]:
    for _ in range(10):
        tracker.next_frame()
        tracker.says_state(claims=False)
        world.pass_time(0.1)
    topic = f"{world.namespace}/tracker/frame_report"
    return [each.msg for each in logs if f"nothing comes on {topic}" in each.msg]


@pytest.mark.usefixtures("no_patience_for_reports")
def test_a_tracker_whose_reports_do_not_come_is_warned_of_once(world, tracker, start):
    logs = world.listen(Log, "/rosout")
    start(settle_time=0.0)
    assert len(warnings_of_missing_reports(world, tracker, logs)) == 1


@pytest.mark.usefixtures("no_patience_for_reports")
@pytest.mark.parametrize("lockstep", [False, True])
def test_missing_reports_are_not_warned_of_after_one_nor_in_lockstep(
    world, tracker, lockstep, start
):
    logs = world.listen(Log, "/rosout")
    start(settle_time=0.0, lockstep=lockstep)
    if not lockstep:
        tracker.reports_are_heard()
        tracker.reports("TRACKING")
        world.empty_queues()
    assert not warnings_of_missing_reports(world, tracker, logs)


@pytest.mark.parametrize(("offset", "heading"), [(0.08, 0.0), (0.0, 0.15)])
def test_a_cable_to_the_left_turns_the_vehicle_to_the_left(tracker, offset, heading, start):
    start()
    tracker.tells(offset, heading)
    assert tracker.commands[-1].linear.x > 0.3
    assert tracker.commands[-1].angular.z > 0.0
    tracker.tells(-offset, -heading, frames=1)
    assert tracker.commands[-1].angular.z < 0.0


def test_each_state_has_one_command(world, tracker, start):
    start()
    tracker.tells(0.1, frames=8)
    world.pass_time(0.3)
    assert len(tracker.commands) == 8


def test_a_state_waits_for_its_cross_track_and_odometry(world, tracker, start):
    start()
    tracker.says_odometry()
    world.empty_queues()
    for _ in range(3):
        tracker.next_frame()
    tracker.says_state(claims=True)
    world.pass_time(0.3)
    assert not tracker.commands
    tracker.says_cross_track(0.1, 0.0)
    world.pass_time(0.3)
    assert not tracker.commands
    tracker.says_odometry()
    world.spin(lambda: tracker.commands)


def test_in_lockstep_a_state_waits_for_the_report_of_its_frame(world, tracker, start):
    start(lockstep=True)
    tracker.next_frame()
    tracker.says_odometry()
    tracker.says_state(claims=True)
    world.pass_time(0.2)
    assert not tracker.commands
    tracker.reports(no_metres="no camera calibration")
    # Long before the time to settle is over.
    world.spin(lambda: tracker.commands, 30.0)


def test_in_lockstep_a_state_waits_for_the_cross_track_of_its_report(world, tracker, start):
    start(lockstep=True)
    tracker.next_frame()
    tracker.says_odometry()
    tracker.says_state(claims=True)
    tracker.reports(offset="0.1")
    world.pass_time(0.2)
    assert not tracker.commands
    tracker.says_cross_track(0.1, 0.0)
    world.spin(lambda: tracker.commands, 30.0)


def test_waiting_for_a_cross_track_has_a_time_limit(world, tracker, start):
    start(settle_time=0.1)
    tracker.next_frame()
    tracker.says_state(claims=True)
    world.spin(lambda: tracker.commands)
    assert tracker.commands[0].linear.x == 0.0


def test_a_lost_cable_stops_the_vehicle(tracker, start):
    node = start()
    tracker.tells(0.0, frames=10)
    tracker.loses(10)
    assert node.mode is Mode.STOPPED
    assert (tracker.commands[-1].linear.x, tracker.commands[-1].angular.z) == (0.0, 0.0)


def test_a_tracker_that_falls_silent_stops_the_vehicle(world, tracker, start):
    start(state_timeout=0.3)
    tracker.tells(0.0, frames=CONFIRMATIONS + 1)
    # Where the machine is busy, it may have stopped between two frames as well.
    assert any(command.linear.x > 0.0 for command in tracker.commands)
    world.spin(lambda: tracker.commands[-1].linear.x == 0.0)


@pytest.mark.parametrize("status", ["DISABLED", "WARMING UP", "FROZEN INPUT"])
def test_while_the_tracker_looks_at_nothing_the_vehicle_stands(
    world, tracker, status, start, statuses
):
    node = start()
    tracker.tells(0.0, frames=10)
    assert tracker.commands[-1].linear.x > 0.0
    tracker.reports_are_heard()
    tracker.reports(status)
    world.empty_queues()
    for _ in range(30):
        tracker.next_frame()
        tracker.says_state(claims=False)
        world.empty_queues()
    assert tracker.commands[-1] == Twist()
    world.spin(lambda: statuses(node)[-1:] == [status])
    tracker.reports("TRACKING")
    world.empty_queues()
    tracker.tells(0.0, frames=10)
    assert tracker.commands[-1].linear.x > 0.0


def test_while_every_frame_is_refused_the_vehicle_stands(world, tracker, start, statuses):
    node = start(state_timeout=0.5)
    tracker.tells(0.0, frames=10)
    tracker.reports_are_heard()

    def is_reported_after_one_more() -> bool:
        tracker.refuses()
        return statuses(node)[-1:] == ["REFUSED"]

    world.spin(is_reported_after_one_more, 60.0)
    assert tracker.commands[-1] == Twist()
    tracker.reports("TRACKING")
    world.empty_queues()
    tracker.tells(0.0, frames=10)
    assert any(command.linear.x > 0.0 for command in tracker.commands[-10:])


def test_one_refused_frame_does_not_stop_the_vehicle(tracker, start, statuses):
    node = start()
    tracker.tells(0.0, frames=10)
    tracker.reports_are_heard()
    tracker.refuses()
    assert tracker.commands[-1].linear.x > 0.0
    assert "REFUSED" not in statuses(node)


@pytest.mark.parametrize("is_sent_twice", [False, True])
def test_a_cable_that_refused_frames_come_between_is_followed(world, tracker, is_sent_twice, start):
    node = start()
    tracker.reports_are_heard()
    for _ in range(CONFIRMATIONS):
        assert node.mode is Mode.WAITING
        tracker.next_frame()
        tracker.says_odometry()
        tracker.reports("TRACKING", offset="0.0")
        tracker.says_cross_track(0.0, 0.0)
        tracker.says_state(claims=True)
        if not is_sent_twice:
            tracker.next_frame()
            tracker.says_odometry()
        tracker.reports("REFUSED")
        tracker.says_state(claims=False)
        world.empty_queues()
    assert node.mode is Mode.FOLLOWING


def test_a_frame_that_comes_twice_waits_for_what_came_with_the_first(world, tracker, start):
    node = start()
    tracker.reports_are_heard()
    tracker.says_odometry()
    tracker.reports("TRACKING", offset="0.0")
    tracker.says_state(claims=True)
    tracker.reports("REFUSED")
    tracker.says_state(claims=False)
    world.empty_queues()
    assert not tracker.commands
    tracker.says_cross_track(0.0, 0.0)
    world.spin(lambda: len(tracker.commands) == 2)
    assert node.mode is Mode.WAITING


def test_a_state_of_a_time_that_no_message_has_room_for_ends_nothing(world, tracker, statuses):
    node = world.controller(settle_time=0.0, state_timeout=0.5)
    node.on_state(JointState(header=Header(stamp=Time(sec=2**31 - 1, nanosec=10**9))))
    world.spin(lambda: statuses(node) == ["NO STATE"])
    assert not tracker.commands


def test_a_state_of_such_a_time_is_silence_for_a_vehicle_that_moves(
    world, tracker, start, statuses
):
    node = start(state_timeout=2.0)
    tracker.tells(0.0, frames=10)
    assert any(command.linear.x > 0.0 for command in tracker.commands)

    def is_reported_after_one_more() -> bool:
        node.on_state(JointState(header=Header(stamp=Time(sec=2**31 - 1, nanosec=10**9))))
        return statuses(node)[-1:] == ["NO STATE"]

    world.spin(is_reported_after_one_more, 60.0)
    assert tracker.commands[-1] == Twist()


def test_a_change_of_mode_is_in_the_diagnostics(world, tracker, start, statuses):
    node = start()
    tracker.tells(0.0)
    world.spin(lambda: statuses(node) == ["WAITING", "FOLLOWING"])


def test_a_tracker_that_falls_silent_is_in_the_diagnostics(
    world, tracker, diagnostics, start, statuses
):
    node = start(state_timeout=0.3)
    tracker.tells(0.0, frames=CONFIRMATIONS + 1)
    world.spin(lambda: statuses(node)[-1:] == ["NO STATE"])
    count = len(diagnostics(node))
    tracker.tells(0.0, frames=1)
    world.spin(lambda: statuses(node)[count:][:1] == ["FOLLOWING"])


def test_silence_and_a_disabled_tracker_are_both_in_the_diagnostics(
    world, tracker, start, statuses
):
    node = start(state_timeout=0.3)
    world.spin(lambda: statuses(node) == ["NO STATE"])
    tracker.reports_are_heard()
    tracker.reports("DISABLED")
    world.empty_queues()
    tracker.next_frame()
    tracker.says_state(claims=False)
    world.spin(lambda: statuses(node) == ["NO STATE", "DISABLED", "NO STATE"])


def test_before_the_first_state_nothing_is_commanded(world, tracker, statuses):
    node = world.controller(settle_time=60.0, state_timeout=0.1)
    world.spin(lambda: statuses(node) == ["NO STATE"])
    assert not tracker.commands


def test_a_controller_that_ends_stops_the_vehicle(world, tracker, start):
    node = start()
    tracker.tells(0.0)
    assert tracker.commands[-1].linear.x > 0.0
    world.remove(node)
    world.spin(lambda: tracker.commands[-1].linear.x == 0.0)


def test_odometry_that_does_not_know_or_is_old_does_not_count(world):
    node = world.controller(**PATIENT)
    message = Odometry(header=Header(stamp=Time(sec=1)))
    message.pose.pose.position.x = math.nan
    node.on_odometry(message)
    assert node._pose_at(1_000_000_000) is None
    message.pose.pose.position.x = 2.0
    node.on_odometry(message)
    assert node._pose_at(1_100_000_000).x == 2.0
    assert node._pose_at(1_500_000_000) is None


@pytest.mark.parametrize("orientation", [{"w": 0.0}, {"w": math.nan}, {"z": 5.0, "w": 5.0}])
def test_odometry_whose_orientation_is_no_rotation_does_not_count(world, orientation):
    node = world.controller(**PATIENT)
    message = odometry_at(1.0, 2.0)
    message.pose.pose.orientation = Quaternion(**orientation)
    node.on_odometry(message)
    assert node._pose_at(1_000_000_000) is None


def odometry_at(seconds: float, x: float) -> Odometry:
    sec, nanosec = divmod(round(seconds * 1e9), 10**9)
    message = Odometry(header=Header(stamp=Time(sec=sec, nanosec=nanosec)))
    message.pose.pose.position.x = x
    return message


@pytest.mark.parametrize("latency", [0.0, 0.1, 0.25, 0.6])
def test_the_pose_nearest_to_the_picture_counts_however_late_the_state_comes(world, latency):
    node = world.controller(**PATIENT)
    for step in range(50):
        node.on_odometry(odometry_at(1.0 + 0.02 * step, 0.01 * step))
    pose = node._pose_at(round((1.983 - latency) * 1e9))
    assert pose is not None
    assert pose.x == pytest.approx(0.5 * (0.983 - latency), abs=0.006)


@pytest.mark.parametrize("odometry", [[], [0.997], [1.012], [0.5, 0.99, 1.04], [1.5]])
def test_no_state_waits_for_odometry_of_its_very_time(world, odometry):
    node = world.controller(**PATIENT)
    for seconds in odometry:
        node.on_odometry(odometry_at(seconds, 2.0))
    assert node._is_complete(1_000_000_000, has_position=False)


def test_a_state_waits_for_odometry_that_is_behind(world):
    node = world.controller(**PATIENT)
    node.on_odometry(odometry_at(0.5, 2.0))
    assert not node._is_complete(1_000_000_000, has_position=False)


@pytest.mark.parametrize("odometry", [[], [0.997], [1.012], [1.5]])
def test_in_lockstep_a_state_waits_for_odometry_of_its_very_time(world, odometry):
    node = world.controller(lockstep=True, settle_time=60.0)
    for seconds in odometry:
        node.on_odometry(odometry_at(seconds, 2.0))
    assert not node._is_complete(1_000_000_000, has_position=False)
    node.on_odometry(odometry_at(1.0, 2.0))
    assert node._is_complete(1_000_000_000, has_position=False)


def test_odometry_without_a_stamp_is_of_the_time_when_it_came(world):
    node = world.controller(**PATIENT)
    node.on_odometry(odometry_at(0.0, 2.0))
    assert node._pose_at(int(node.get_clock().now().nanoseconds)).x == 2.0


@pytest.mark.usefixtures("ros_environment")
def test_a_controller_without_its_context_ends_without_an_error():
    context = started_context([])
    node = ControllerNode(context=context)
    node._last_command = Command(surge=0.3)
    rclpy.try_shutdown(context=context)
    node.destroy_node()
