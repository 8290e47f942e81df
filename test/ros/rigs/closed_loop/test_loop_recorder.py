from __future__ import annotations

from typing import Any

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import Header

from cable_tracker.ros.rigs.closed_loop.loop_recorder import LoopRecorder
from cable_tracker.tracking.status import WARMING_UP


class Loop:
    """Publishes what the nodes of a closed loop would, about frames one second apart."""

    TOPICS = {  # noqa: RUF012
        "image": Image,
        "state": JointState,
        "tracker/frame_report": DiagnosticArray,
        "ground_truth/odometry": Odometry,
        "ground_truth/cross_track": PoseWithCovarianceStamped,
        "cross_track": PoseWithCovarianceStamped,
        "diagnostics": DiagnosticArray,
    }

    def __init__(self, world: Any, recorder: LoopRecorder, but: tuple[str, ...] = ()) -> None:
        self._world = world
        self._recorder = recorder
        self._publishers = {
            topic: world.me.create_publisher(kind, topic, 50)
            for topic, kind in self.TOPICS.items()
            if topic not in but
        }
        world.spin(lambda: all(each.get_subscription_count() for each in self._publishers.values()))

    def says(self, topic: str, second: int) -> None:
        message = self.TOPICS[topic](header=Header(stamp=Time(sec=second)))
        if topic == "image":
            message.height, message.width, message.step = 4, 6, 6
            message.encoding, message.data = "mono8", bytes(24)
        elif topic == "tracker/frame_report":
            message.status.append(DiagnosticStatus(message="TRACKING"))
        elif topic.endswith("cross_track"):
            message.pose.pose.position.y = 0.25
        self._publishers[topic].publish(message)

    def says_all(self, second: int, *, but: tuple[str, ...] = ()) -> None:
        for topic in self.TOPICS:
            if topic not in but and topic != "diagnostics":
                self.says(topic, second)

    def tells(self, second: int, name: str, message: str, **values: str) -> None:
        status = DiagnosticStatus(name=name, message=message)
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        array = DiagnosticArray(header=Header(stamp=Time(sec=second)), status=[status])
        self._publishers["diagnostics"].publish(array)

    def seen(self, count: int) -> list[int]:
        taken: list[int] = []

        def has_come() -> bool:
            taken.extend(frame.stamp // 1_000_000_000 for frame in self._recorder.take())
            return len(taken) >= count

        self._world.spin(has_come)
        return taken


@pytest.fixture
def recorder(world: Any) -> LoopRecorder:
    return world.add(LoopRecorder(world.context, world.namespace))


@pytest.fixture
def loop(world: Any, recorder: LoopRecorder) -> Loop:
    return Loop(world, recorder)


def test_frames_are_seen_once_and_in_order(loop, recorder):
    for second in (1, 2, 3):
        loop.says_all(second)
    assert loop.seen(3) == [1, 2, 3]
    assert recorder.take() == []
    assert recorder.is_settled()


def test_a_frame_is_seen_when_all_about_it_has_come(world, loop, recorder):
    loop.says_all(1, but=("state",))
    world.pass_time(0.3)
    assert recorder.take() == []
    assert not recorder.is_settled()
    loop.says("state", 1)
    assert loop.seen(1) == [1]


def test_a_frame_is_recorded_without_its_image(world):
    recorder = world.add(LoopRecorder(world.context, world.namespace, with_images=False))
    loop = Loop(world, recorder, but=("image",))
    loop.says_all(1, but=("image", "state"))
    world.pass_time(0.3)
    assert not recorder.is_settled()
    loop.says("state", 1)
    assert loop.seen(1) == [1]
    assert recorder.is_settled()


def test_the_tracker_is_warm_when_its_diagnostics_say_so(world, loop, recorder):
    assert not recorder.is_warm()
    loop.tells(1, "tracker", WARMING_UP, **{"subscribers of /x/cross_track": "1"})
    world.pass_time(0.3)
    assert not recorder.is_warm()
    loop.tells(2, "controller: guidance", "FOLLOWING")
    world.pass_time(0.3)
    assert not recorder.is_warm()
    loop.tells(3, "tracker", "INITIALISING")
    world.spin(recorder.is_warm)


def test_a_frame_that_the_tracker_left_out_has_a_row(loop, recorder):
    loop.says_all(1, but=("state", "tracker/frame_report", "cross_track"))
    loop.says_all(2)
    assert loop.seen(1) == [2]
    first, second = recorder.rows()
    assert (first.status, first.is_measured) == ("", False)
    assert (second.status, second.measured_offset, second.time) == ("TRACKING", 0.25, 1.0)


def test_the_mode_holds_from_its_time_on(world, loop, recorder):
    loop.tells(2, "/controller: guidance", "FOLLOWING")
    for second in (1, 2, 3):
        loop.says_all(second)
    loop.seen(3)
    world.spin(lambda: recorder.rows()[-1].mode == "FOLLOWING")
    assert [row.mode for row in recorder.rows()] == ["WAITING", "FOLLOWING", "FOLLOWING"]


def test_the_recorder_is_connected_when_the_tracker_knows_two_readers(world, loop, recorder):
    counts = {"subscribers of /x/state": "2", "subscribers of /x/tracker/frame_report": "1"}
    loop.tells(1, "tracker", "", **counts, **{"subscribers of /x/cross_track": "1"})
    world.pass_time(0.3)
    assert not recorder.is_connected()
    loop.tells(2, "tracker", "", **counts, **{"subscribers of /x/cross_track": "2"})
    world.spin(recorder.is_connected)
