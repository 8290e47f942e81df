from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

from cable_tracker.errors import RosError
from cable_tracker.ros.clients.recorder import ACKNOWLEDGED, RecordedFrame, Recorder, spin_until
from cable_tracker.ros.nodes.tracker_node import TrackerNode
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.cable import read_particles
from cable_tracker.sequences.messages.headers import stamp_of


@pytest.fixture
def recorder(world: Any, context: Any, namespace: str) -> Recorder:
    return world.add(Recorder(context, namespace, node_topics.CABLE_TOPICS))


@pytest.fixture
def tracker(world: Any, context: Any, namespace: str, near: str) -> TrackerNode:
    """A tracker whose diagnostics stay within the namespace, as `track --ros` starts it."""
    node = TrackerNode(
        context=context,
        namespace=namespace,
        cli_args=["--ros-args", "-r", "/diagnostics:=diagnostics"],
        parameter_overrides=[
            Parameter("initial_state", value=near),
            Parameter("diagnostics_period", value=0.05),
        ],
    )
    node.wait_until_warm()
    return world.add(node)  # type: ignore[no-any-return]


@pytest.fixture
def take(world: Any, recorder: Recorder) -> Callable[[], RecordedFrame]:
    """Spin until everything about the next frame has come."""

    def taken() -> RecordedFrame:
        frames: list[RecordedFrame] = []

        def has_come() -> bool:
            frame = recorder.take()
            if frame is not None:
                frames.append(frame)
            return bool(frames)

        world.spin(has_come)
        return frames[0]

    return taken


def test_diagnostics_tell_the_recorder_that_the_tracker_is_subscribed(
    world: Any, recorder: Recorder, tracker: TrackerNode
) -> None:
    world.spin(recorder.is_subscribed)
    assert recorder.take_diagnostics()
    assert recorder.take_diagnostics() == []
    assert not recorder.is_subscribed()


def test_the_recorder_waits_while_there_is_no_tracker(world: Any, recorder: Recorder) -> None:
    world.pass_time(0.1)
    assert not recorder.is_subscribed()
    assert recorder.take() is None


def test_all_messages_about_a_frame_are_put_together(
    world: Any,
    recorder: Recorder,
    tracker: TrackerNode,
    take: Callable[[], RecordedFrame],
    image_message: Callable[..., Any],
) -> None:
    for index in range(4):
        world.show(tracker, image_message(index=index))
    for index in range(4):
        frame = take()
        assert frame.status == "TRACKING"
        assert set(frame.messages) == {
            node_topics.STATE,
            node_topics.FRAME_REPORT,
            node_topics.CENTRELINE,
            node_topics.PARTICLES,
            node_topics.MARKERS,
            node_topics.OVERLAY,
        }
        stamp = stamp_of(image_message(index=index).header)
        stamped = set(frame.messages) - {node_topics.MARKERS}
        assert {stamp_of(frame.read(topic).header) for topic in stamped} == {stamp}
        assert read_particles(frame.read(node_topics.PARTICLES)).shape == (500, 9)
    assert recorder.take() is None


def test_frames_of_every_status_are_told_apart(
    world: Any,
    tracker: TrackerNode,
    recorder: Recorder,
    take: Callable[[], RecordedFrame],
    image_message: Callable[..., Any],
) -> None:
    blank = np.full((240, 320), 90, np.uint8)
    world.show(tracker, image_message(index=0))
    world.show(tracker, image_message(index=1, step=1))
    for index in range(2, 16):
        world.show(tracker, image_message(blank, index=index))
    tracker.on_enable(SetBool.Request(data=False), SetBool.Response())
    world.show(tracker, image_message(index=16))
    frames = [take() for _ in range(17)]
    assert [frame.status for frame in frames[:2]] == ["TRACKING", "REFUSED"]
    assert frames[15].status == "LOST"
    assert frames[16].status == "DISABLED"
    for frame in frames:
        has_line = node_topics.CENTRELINE in frame.messages
        assert has_line == (frame.status == "TRACKING")
        has_pictures = node_topics.OVERLAY in frame.messages
        assert has_pictures == (frame.status in ("TRACKING", "LOST"))


def test_a_recorded_frame_is_acknowledged(world: Any, recorder: Recorder) -> None:
    heard = world.listen(JointState, ACKNOWLEDGED)
    state = JointState(name=["d"])
    recorder.acknowledge(state)
    world.spin(lambda: heard)
    assert heard == [state]


class TestSpinUntil:
    def test_spinning_ends_when_the_condition_holds(self, world: Any) -> None:
        turns = iter(range(10))
        spin_until(world.executor, lambda: next(turns) == 3, 300.0, lambda: "")
        assert next(turns) == 4

    def test_silence_is_an_error_after_some_time(self, world: Any) -> None:
        begin = time.monotonic()
        with pytest.raises(RosError, match=r"nothing came for 0\.2 s"):
            spin_until(world.executor, lambda: False, 0.2, lambda: "")
        assert time.monotonic() - begin >= 0.2

    def test_queued_messages_are_handled_after_the_deadline(self, world: Any) -> None:
        heard = world.listen(JointState, "late")
        publisher = world.me.create_publisher(JointState, "late", 10)
        for number in range(5):
            publisher.publish(JointState(name=[str(number)]))
        # As after a long halt of this process: the deadline is over before the first turn.
        spin_until(world.executor, lambda: len(heard) == 5, -1.0, lambda: "")

    def test_a_complaint_is_an_error_at_once(self, world: Any) -> None:
        with pytest.raises(RosError, match="the node has died"):
            spin_until(world.executor, lambda: False, 60.0, lambda: "the node has died")


def test_a_tracker_that_warms_up_is_waited_for_beyond_the_time_out(
    world: Any, recorder: Recorder, capfd: pytest.CaptureFixture[str]
) -> None:
    publisher = world.me.create_publisher(DiagnosticArray, "diagnostics", 1)
    world.spin(publisher.get_subscription_count)

    def says(status: str) -> Any:
        publisher.publish(DiagnosticArray(status=[DiagnosticStatus(message=status)]))
        world.pass_time(0.1)
        return recorder.is_warming()

    world.spin(lambda: says("WARMING UP"))
    assert "the tracker is WARMING UP" in capfd.readouterr().err
    turns: list[int] = []

    def has_come() -> bool:
        turns.append(1)
        return len(turns) > 20

    # Each turn begins the time-out anew, which all of them together exceed.
    spin_until(world.executor, has_come, 0.3, lambda: "", recorder.is_warming)
    world.spin(lambda: not says("INITIALISING"))
    with pytest.raises(RosError, match=r"nothing came for 0\.1 s"):
        spin_until(world.executor, lambda: False, 0.1, lambda: "", recorder.is_warming)
