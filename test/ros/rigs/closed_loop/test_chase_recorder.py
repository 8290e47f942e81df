from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.duration import Duration
from sensor_msgs.msg import CompressedImage, JointState
from std_msgs.msg import Header

from cable_tracker.ros.process.node_group import NodeGroup
from cable_tracker.ros.rigs.closed_loop.chase_recorder import ChaseRecorder, ChaseVideoFrame
from cable_tracker.ros.rigs.closed_loop.run_recorder import listen_to_the_end
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg

PICTURE = np.full((48, 64, 3), 90, np.uint8)


class Chase:
    """Publishes what simulator and tracker would, about frames one second apart."""

    TOPICS = {  # noqa: RUF012
        "ground_truth/target": PoseWithCovarianceStamped,
        "state": JointState,
        "target_tracker/frame_report": DiagnosticArray,
        "relative_pose": PoseWithCovarianceStamped,
        "target_tracker/overlay/compressed": CompressedImage,
    }

    def __init__(self, world: Any) -> None:
        self._publishers = {
            topic: world.me.create_publisher(kind, topic, 50) for topic, kind in self.TOPICS.items()
        }
        world.spin(lambda: all(each.get_subscription_count() for each in self._publishers.values()))

    def says(self, topic: str, second: int) -> None:
        message = self.TOPICS[topic](header=Header(stamp=Time(sec=second)))
        if topic == "state":
            message.position = [1.0]
        elif topic == "target_tracker/frame_report":
            message.status = [
                DiagnosticStatus(message="TRACKING", values=[KeyValue(key="x", value="2.5")])
            ]
        elif topic.endswith("compressed"):
            message.format, message.data = "jpeg", encode_jpeg(PICTURE).data
        else:
            message.pose.pose.position.x = 2.5
        self._publishers[topic].publish(message)
        assert self._publishers[topic].wait_for_all_acked(Duration(seconds=60))

    def says_all(self, second: int, *, but: str = "") -> None:
        for topic in self.TOPICS:
            if topic != but:
                self.says(topic, second)


@pytest.fixture
def recorder(world: Any) -> ChaseRecorder:
    return world.add(ChaseRecorder(world.context, world.namespace))


def test_messages_that_still_wait_when_the_simulator_has_ended_are_recorded(world, recorder):
    chase = Chase(world)
    for second in (1, 2, 3):
        chase.says_all(second)
    shown: list[ChaseVideoFrame] = []
    listen_to_the_end(
        recorder,
        world.executor,
        NodeGroup(world.namespace),
        SimpleNamespace(running=False),
        show=shown.append,
        has_settled=lambda _: recorder.is_settled(),
    )
    assert [row.time for row in recorder.rows()] == [0.0, 1.0, 2.0]
    assert [row.range for row in recorder.rows()] == [2.5, 2.5, 2.5]
    assert [frame.picture.shape for frame in shown] == [PICTURE.shape] * 3


@pytest.mark.parametrize("late", ["state", "target_tracker/frame_report", "relative_pose"])
def test_a_frame_is_answered_when_all_about_it_has_come(world, recorder, late):
    chase = Chase(world)
    chase.says_all(1, but=late)
    world.spin(lambda: recorder.received == 4)
    assert recorder.take() == []
    assert not recorder.is_settled()
    chase.says(late, 1)
    world.spin(recorder.take)
    assert recorder.is_settled()
