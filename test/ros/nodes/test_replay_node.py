from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import (
    CameraInfo,
    CompressedImage,
    Image,
    Imu,
    JointState,
    NavSatFix,
    Range,
)
from std_srvs.srv import SetBool, Trigger

from cable_tracker.errors import ParameterError, RecordingError, RosError
from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.node_parameter_tables import ReplayStartParameters
from cable_tracker.ros import endpoints, qos
from cable_tracker.ros.nodes import replay_instruments, replay_node, replay_subscribers
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.cable import read_state
from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.messages.images import make_image, read_compressed_image, read_image
from cable_tracker.sequences.messages.static_transforms import TF_TYPE
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.sequences.source import open_source
from cable_tracker.tracking.status import WARMING_UP

Dive = Callable[..., Path]
MILLISECOND = 1_000_000


def play_to_the_end(world: Any, node: Any, heard: list[Any]) -> None:
    world.spin(lambda: node.finished)
    world.spin(lambda: len(heard) == node.sent)


def stamps_of(messages: list[Any]) -> list[int]:
    return [stamp_of(message.header) for message in messages]


def indices_of(messages: list[Any]) -> list[int]:
    """Numbers of the frames of a dive, which has 25 frames per second from 1 s on."""
    return [round((stamp - 1_000_000_000) / (40 * MILLISECOND)) for stamp in stamps_of(messages)]


@pytest.fixture
def bag_with_a_bad_frame(tmp_path: Path, dive_frames: Callable[..., Iterator[Frame]]) -> Path:
    """Write a dive of four frames, of which the third cannot be decoded."""
    factory = RosbagsMessages()
    with BagWriter(tmp_path / "bad") as bag:
        for frame in dive_frames(4):
            message = make_image(factory, frame.image, make_header(factory, frame.stamp, "camera"))
            if frame.index == 2:
                message.step = 1
            bag.write("/image", "sensor_msgs/msg/Image", message, frame.stamp)
    return tmp_path / "bad"


@pytest.fixture
def sources(
    tmp_path: Path, make_dive: Dive, dive_frames: Callable[..., Iterator[Frame]]
) -> Callable[[str], Path]:
    """Write a dive of five frames as a recording of some kind."""

    def write(kind: str) -> Path:
        if kind in ("mcap", "sqlite3"):
            return make_dive(5, storage=kind)
        if kind == "jpeg":
            return make_dive(5, jpeg=True)
        write_sequence(tmp_path / "pictures", dive_frames(5))
        if kind == "sequence":
            return tmp_path / "pictures" / "sequence.txt"
        return tmp_path / "pictures"

    return write


class TestSources:
    @pytest.mark.parametrize("kind", ["mcap", "sqlite3", "folder", "sequence", "jpeg"])
    def test_every_frame_is_sent_as_it_was_recorded(
        self, world: Any, sources: Callable[[str], Path], kind: str
    ) -> None:
        path = sources(kind)
        recorded = list(open_source(path).frames())
        compressed = kind == "jpeg"
        topic = (CompressedImage, "image/compressed") if compressed else (Image, "image")
        heard, truths = world.listen(*topic), world.listen(JointState, "ground_truth")
        node = world.replay(source=str(path), rate=10)
        play_to_the_end(world, node, heard)
        assert node.sent == len(heard) == 5
        for message, frame in zip(heard, recorded, strict=True):
            image = read_compressed_image(message) if compressed else read_image(message)
            assert (decode_grey(image) == decode_grey(frame.image)).all()
            assert stamp_of(message.header) == frame.stamp
            assert message.header.frame_id == frame.frame_id == "camera"
        if kind == "folder":
            assert not truths
            return
        world.spin(lambda: len(truths) == 5)
        assert [read_state(truth) for truth in truths] == [frame.truth for frame in recorded]
        assert stamps_of(truths) == stamps_of(heard)

    def test_labels_can_be_given_to_a_recording_without(
        self, world: Any, sources: Callable[[str], Path]
    ) -> None:
        folder = sources("folder")
        truths = world.listen(JointState, "ground_truth")
        world.replay(source=str(folder), truth=str(folder / "sequence.txt"), rate=10)
        world.spin(lambda: len(truths) == 5)
        assert all(read_state(truth) for truth in truths)

    def test_at_the_end_a_replay_reports_what_it_sent(
        self, world: Any, make_dive: Dive, capfd: pytest.CaptureFixture[str]
    ) -> None:
        path = make_dive(3)
        node = world.replay(source=str(path), rate=100)
        world.spin(lambda: node.finished)
        assert node.report().startswith(f"sent 3 frames of {path} in ")
        world.remove(node)
        assert f"sent 3 frames of {path}" in capfd.readouterr().err


class TestBadSources:
    def test_a_source_must_be_named(self, world: Any) -> None:
        with pytest.raises(ParameterError, match="source: name the recording"):
            world.replay()

    @pytest.mark.parametrize("name", ["", "dive.mcap", "dive.mp4", "folder"])
    def test_a_missing_recording_is_refused(self, world: Any, tmp_path: Path, name: str) -> None:
        with pytest.raises(RecordingError, match=r"there is no such file|the folder is empty"):
            world.replay(source=str(tmp_path / name) if name else str(tmp_path))

    def test_an_unknown_topic_is_refused(self, world: Any, make_dive: Dive) -> None:
        with pytest.raises(RecordingError, match="/other"):
            world.replay(source=str(make_dive(1)), topic="/other")

    def test_frames_before_the_damage_are_sent(self, world: Any, damaged_dive: Path) -> None:
        readable = []
        with pytest.raises(RecordingError):
            for frame in open_source(damaged_dive).frames():
                readable.append(frame.stamp)
        heard = world.listen(Image, "image")
        node = world.replay(source=str(damaged_dive), rate=100)
        with pytest.raises(RecordingError, match=str(damaged_dive)):
            world.spin(lambda: node.finished)
        world.nodes.remove(node)
        world.spin(lambda: len(heard) == len(readable))
        assert 0 < len(readable) < 12
        assert stamps_of(heard) == readable
        node.destroy_node()

    @pytest.mark.parametrize("skip", [False, True])
    def test_a_frame_that_cannot_be_decoded_is_sent_only_on_request(
        self,
        world: Any,
        bag_with_a_bad_frame: Path,
        skip: bool,
    ) -> None:
        heard = world.listen(Image, "image")
        source = str(bag_with_a_bad_frame)
        node = world.replay(source=source, rate=100, skip_bad_frames=skip)
        if skip:
            play_to_the_end(world, node, heard)
            assert indices_of(heard) == [0, 1, 2, 3]
            return
        world.ends_with(node, RecordingError, "frame 2 cannot be decoded")
        assert node.sent == 2

    def test_the_reason_for_an_empty_image_is_logged(
        self, world: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]
    ) -> None:
        (tmp_path / "0.png").write_bytes(b"no picture")
        heard = world.listen(Image, "image")
        node = world.replay(source=str(tmp_path), rate=100, skip_bad_frames=True)
        play_to_the_end(world, node, heard)
        assert not heard[0].data
        assert "frame 0 cannot be decoded (the data is no picture" in capfd.readouterr().err


class TestTiming:
    @pytest.mark.parametrize(("rate", "seconds"), [(1.0, 0.4), (4.0, 0.1)])
    def test_frames_keep_their_times_scaled_by_the_rate(
        self, world: Any, make_dive: Dive, rate: float, seconds: float
    ) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(11)), rate=rate)
        begin = time.monotonic()
        play_to_the_end(world, node, heard)
        elapsed = time.monotonic() - begin
        assert indices_of(heard) == list(range(11))
        # How much later it ends says how busy the machine is.
        assert elapsed >= seconds - 0.03

    @pytest.mark.parametrize(
        ("start", "duration", "expected"),
        [
            (0.0, 0.0, range(10)),
            (0.2, 0.0, range(5, 10)),
            (0.0, 0.12, range(3)),
            (0.08, 0.08, range(2, 4)),
            (0.36, 0.0, range(9, 10)),
        ],
    )
    def test_start_and_duration_choose_a_part(
        self, world: Any, make_dive: Dive, start: float, duration: float, expected: range
    ) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(10)), rate=100, start=start, duration=duration)
        play_to_the_end(world, node, heard)
        assert indices_of(heard) == list(expected)

    def test_a_loop_begins_again_at_its_start(self, world: Any, make_dive: Dive) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(4)), rate=100, start=0.08, loop=True)
        world.spin(lambda: len(heard) >= 6)
        assert indices_of(heard)[:6] == [2, 3] * 3
        assert not node.finished
        node.set_parameters([Parameter("loop", value=False)])
        play_to_the_end(world, node, heard)
        assert len(heard) % 2 == 0

    @pytest.mark.parametrize(("frames", "interval"), [(3, 0.04), (1, 0.1)])
    def test_the_rounds_of_a_loop_follow_on_each_other_as_frames_do(
        self,
        world: Any,
        make_dive: Dive,
        monkeypatch: pytest.MonkeyPatch,
        frames: int,
        interval: float,
    ) -> None:
        clock = SimpleNamespace(monotonic=lambda: 1000.0)
        monkeypatch.setattr(replay_node, "time", clock)
        node = world.replay(source=str(make_dive(frames)), loop=True, frame_rate=10.0)
        for count in range(1, 3 * frames):
            for _ in range(3):
                node.work()
            assert node.sent == count
            clock.monotonic = lambda now=1000.001 + count * interval: now

    def test_a_loop_over_nothing_waits_for_a_better_start(
        self, world: Any, make_dive: Dive, capfd: pytest.CaptureFixture[str]
    ) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(3)), rate=100, loop=True)
        world.spin(lambda: heard)
        node.set_parameters([Parameter("start", value=9.0)])
        world.spin(lambda: node._awaits_restart)
        node.work()
        assert not node.finished
        assert capfd.readouterr().err.count("start: no frame after that time") == 1
        sent = node.sent
        node.set_parameters([Parameter("start", value=0.0)])
        assert world.call(Trigger, "replay/restart").success
        world.spin(lambda: node.sent > sent)

    def test_a_new_start_waits_for_the_next_restart(self, world: Any, make_dive: Dive) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(8)), paused=True)
        step(world, heard)
        node.set_parameters([Parameter("start", value=0.2)])
        step(world, heard)
        step(world, heard)
        assert indices_of(heard) == [0, 1, 2]
        assert world.call(Trigger, "replay/restart").message == "at frame 5"
        step(world, heard)
        assert indices_of(heard) == [0, 1, 2, 5]

    def test_frames_are_sent_also_where_the_recorded_clock_jumps_back(
        self, world: Any, tmp_path: Path, dive_frames: Callable[..., Iterator[Frame]]
    ) -> None:
        times = [2_000, 2_040, 500, 540, 2_080]
        frames = [
            Frame(frame.index, milliseconds * MILLISECOND, frame.image)
            for frame, milliseconds in zip(dive_frames(5), times, strict=True)
        ]
        for frame in frames:
            write_bag(tmp_path / f"part{frame.index}", [frame])
        factory = RosbagsMessages()
        with BagWriter(tmp_path / "jump") as bag:
            for frame in frames:
                header = make_header(factory, frame.stamp, "camera")
                message = make_image(factory, frame.image, header)
                # The recorder's clock goes on; that of the camera does not.
                bag.write("/image", "sensor_msgs/msg/Image", message, 10**9 + frame.index)
        heard = world.listen(Image, "image")
        node = world.replay(source=str(tmp_path / "jump"), rate=100)
        play_to_the_end(world, node, heard)
        assert stamps_of(heard) == [milliseconds * MILLISECOND for milliseconds in times]

    def test_a_clock_that_was_set_far_ahead_is_not_waited_for(
        self, world: Any, tmp_path: Path, dive_frames: Callable[..., Iterator[Frame]]
    ) -> None:
        seconds = [1, 2, 1_700_000_000, 1_700_000_001]
        frames = [
            Frame(frame.index, second * 10**9, frame.image)
            for frame, second in zip(dive_frames(4), seconds, strict=True)
        ]
        write_bag(tmp_path / "set", frames)
        heard = world.listen(Image, "image")
        node = world.replay(source=str(tmp_path / "set"), rate=100)
        play_to_the_end(world, node, heard)
        assert len(heard) == 4

    def test_a_change_of_rate_counts_in_the_middle_of_a_pause(
        self, world: Any, tmp_path: Path, dive_frames: Callable[..., Iterator[Frame]]
    ) -> None:
        frames = [
            Frame(frame.index, (1 + 60 * frame.index) * 10**9, frame.image)
            for frame in dive_frames(2)
        ]
        write_bag(tmp_path / "slow", frames)
        heard = world.listen(Image, "image")
        node = world.replay(source=str(tmp_path / "slow"), rate=0.01)
        world.spin(lambda: len(heard) == 1)
        assert node.set_parameters([Parameter("rate", value=100.0)])[0].successful
        world.spin(lambda: len(heard) == 2)

    def test_the_clock_shows_the_time_of_the_frames(self, world: Any, make_dive: Dive) -> None:
        heard, clock = world.listen(Image, "image"), world.listen(Clock, "/clock")
        node = world.replay(source=str(make_dive(4)), rate=100, publish_clock=True)
        play_to_the_end(world, node, heard)
        world.spin(lambda: len(clock) >= 4)
        times = [message.clock.sec * 10**9 + message.clock.nanosec for message in clock]
        # The topic is absolute: another run of these tests may use it too.
        assert [time for time in times if time in stamps_of(heard)][:4] == stamps_of(heard)

    def test_a_replay_waits_for_a_subscriber_by_default(self, world: Any, make_dive: Dive) -> None:
        assert ReplayStartParameters().wait_for_tracker is True
        node = world.replay(source=str(make_dive(3)), rate=100, wait_for_tracker=True)
        world.pass_time(0.2)
        assert node.sent == 0
        heard = world.listen(Image, "image")
        play_to_the_end(world, node, heard)
        assert len(heard) == 3

    def test_a_subscriber_elsewhere_is_named(
        self,
        world: Any,
        make_dive: Dive,
        monkeypatch: pytest.MonkeyPatch,
        capfd: pytest.CaptureFixture[str],
    ) -> None:
        monkeypatch.setattr(replay_subscribers, "PATIENCE", 0.1)
        world.me.create_subscription(Image, "elsewhere", lambda _: None, 1)
        node = world.replay(source=str(make_dive(2)), wait_for_tracker=True)
        said: list[str] = []

        def is_named() -> bool:
            said.append(capfd.readouterr().err)
            # Other programs of this domain may await some too.
            awaited = rf"images are awaited on .*{world.namespace}/elsewhere"
            return re.search(awaited, "".join(said)) is not None

        world.spin(is_named)
        assert f"no node subscribes to {world.namespace}/image" in "".join(said)
        assert node.sent == 0

    def test_a_replay_without_a_subscriber_is_logged(
        self, world: Any, make_dive: Dive, capfd: pytest.CaptureFixture[str]
    ) -> None:
        node = world.replay(source=str(make_dive(2)), rate=100, wait_for_tracker=False)
        world.spin(lambda: node.sent == 2)
        assert "the first frames reach none" in capfd.readouterr().err

    @pytest.mark.parametrize("lockstep", [True, False])
    def test_a_replay_waits_while_a_tracker_is_warming_up(
        self,
        world: Any,
        make_dive: Dive,
        lockstep: bool,
        capfd: pytest.CaptureFixture[str],
    ) -> None:
        tracker = Talker(world)
        heard = world.listen(Image, "image")
        world.me.create_publisher(JointState, "state", qos.LATEST_RESULT)
        node = world.replay(
            source=str(make_dive(2)), rate=100, wait_for_tracker=True,
            lockstep=lockstep, answer_timeout=0.3, paused=True,
        )  # fmt: skip
        world.spin(tracker.is_heard)
        tracker.says(WARMING_UP)
        world.spin(node._subscribers.warming)
        node._paused = False
        # Longer than answer_timeout, after which it gives up where no tracker is to be seen.
        world.pass_time(0.6)
        assert node.sent == 0 and not heard
        assert "/auv/tracker is WARMING UP" in capfd.readouterr().err
        tracker.says("INITIALISING")
        # Not until it is heard: by then the answer may be overdue.
        world.spin(lambda: node.sent)
        world.nodes.remove(node)
        world.spin(lambda: heard)
        node.destroy_node()

    def test_the_rate_can_be_changed(self, world: Any, make_dive: Dive) -> None:
        node = world.replay(source=str(make_dive(3)), paused=True)
        assert node.set_parameters([Parameter("rate", value=2)])[0].successful
        assert node.get_parameter("rate").value == 2.0

    @pytest.mark.parametrize(
        ("name", "value"), [("rate", 0.0), ("start", -1.0), ("source", "/else"), ("topic", "/x")]
    )
    def test_bad_values_and_another_source_are_refused(
        self, world: Any, make_dive: Dive, name: str, value: object
    ) -> None:
        node = world.replay(source=str(make_dive(3)), paused=True)
        result = node.set_parameters([Parameter(name, value=value)])[0]
        assert not result.successful and name in result.reason


class Talker:
    """Says on /diagnostics what a tracker says."""

    def __init__(self, world: Any) -> None:
        self._publisher = world.me.create_publisher(DiagnosticArray, "/diagnostics", qos.RESULTS)

    def is_heard(self) -> int:
        return int(self._publisher.get_subscription_count())

    def says(self, status: str) -> None:
        entry = DiagnosticStatus(message=status, hardware_id="/auv/tracker")
        self._publisher.publish(DiagnosticArray(status=[entry]))


def step(world: Any, heard: list[Any]) -> None:
    count = len(heard)
    assert world.call(Trigger, "replay/step").success
    world.spin(lambda: len(heard) == count + 1)


class TestServices:
    def test_pause_step_and_go_on(self, world: Any, make_dive: Dive) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(6)), rate=10, paused=True)
        world.pass_time(0.1)
        assert not heard
        step(world, heard)
        step(world, heard)
        world.pass_time(0.1)
        assert indices_of(heard) == [0, 1]
        response = world.call(SetBool, "replay/pause", data=False)
        assert response.success and response.message == "playing"
        play_to_the_end(world, node, heard)
        assert indices_of(heard) == list(range(6))

    def test_pausing_stops_the_frames(self, world: Any, make_dive: Dive) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(15)), rate=1, loop=True)
        world.spin(lambda: len(heard) >= 2)
        assert world.call(SetBool, "replay/pause", data=True).message == "paused"
        world.spin(lambda: len(heard) == node.sent)
        sent = node.sent
        world.pass_time(0.15)
        assert node.sent == sent
        assert world.call(SetBool, "replay/pause", data=False).message == "playing"
        world.spin(lambda: node.sent > sent)

    def test_a_replay_that_is_paused_after_its_last_frame_does_not_end(
        self, world: Any, make_dive: Dive
    ) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(2)), paused=True)
        step(world, heard)
        step(world, heard)
        # Until it would have ended.
        world.spin(lambda: node._image.wait_for_all_acked(Duration()))
        world.empty_queues()
        assert not node.finished
        assert world.call(Trigger, "replay/step").message == "at the end"
        assert world.call(Trigger, "replay/restart").message == "at frame 0"
        assert world.call(SetBool, "replay/pause", data=False).success
        play_to_the_end(world, node, heard)
        assert indices_of(heard) == [0, 1, 0, 1]

    def test_a_replay_paused_before_the_damage_reports_it_at_the_next_step(
        self, world: Any, bag_with_a_bad_frame: Path
    ) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(bag_with_a_bad_frame), paused=True)
        step(world, heard)
        step(world, heard)
        world.empty_queues()
        response = world.call(Trigger, "replay/step")
        assert not response.success and "frame 2 cannot be decoded" in response.message
        node.on_pause(SetBool.Request(data=False), SetBool.Response())
        world.ends_with(node, RecordingError, "frame 2 cannot be decoded")

    def test_stepping_while_playing_is_refused(self, world: Any, make_dive: Dive) -> None:
        world.replay(source=str(make_dive(15)), rate=0.1, loop=True)
        response = world.call(Trigger, "replay/step")
        assert not response.success and response.message == "not paused"

    def test_restart_goes_to_the_start_parameter(self, world: Any, make_dive: Dive) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(8)), paused=True)
        step(world, heard)
        assert world.call(Trigger, "replay/restart").message == "at frame 0"
        step(world, heard)
        node.set_parameters([Parameter("start", value=0.2)])
        response = world.call(Trigger, "replay/restart")
        assert response.success and response.message == "at frame 5"
        step(world, heard)
        assert indices_of(heard) == [0, 0, 5]

    def test_a_restart_after_the_end_of_the_recording_is_refused(
        self, world: Any, make_dive: Dive
    ) -> None:
        heard = world.listen(Image, "image")
        node = world.replay(source=str(make_dive(4)), paused=True)
        step(world, heard)
        node.set_parameters([Parameter("start", value=60.0)])
        response = world.call(Trigger, "replay/restart")
        assert not response.success and response.message == "no frame after that time"
        node.set_parameters([Parameter("start", value=0.0)])
        assert world.call(Trigger, "replay/restart").success

    def test_a_restart_skips_bad_frames_before_its_start_and_reports_one_at_it(
        self, world: Any, bag_with_a_bad_frame: Path
    ) -> None:
        node = world.replay(source=str(bag_with_a_bad_frame), paused=True)
        node.set_parameters([Parameter("start", value=0.12)])
        response = node.on_restart(Trigger.Request(), Trigger.Response())
        assert response.success and response.message == "at frame 3"
        node.set_parameters([Parameter("start", value=0.08)])
        response = node.on_restart(Trigger.Request(), Trigger.Response())
        assert not response.success and "frame 2 cannot be decoded" in response.message
        node.work()
        assert not node.finished

    def test_a_refused_restart_does_not_end_a_replay_that_runs(
        self, world: Any, make_dive: Dive
    ) -> None:
        # So slowly that the call comes long before the end.
        node = world.replay(source=str(make_dive(15)), loop=True, rate=0.01)
        node.set_parameters([Parameter("start", value=60.0)])
        assert not world.call(Trigger, "replay/restart").success
        node.work()
        assert not node.finished

    def test_a_start_after_the_end_is_an_error(self, world: Any, make_dive: Dive) -> None:
        node = world.replay(source=str(make_dive(4)), start=60.0)
        world.ends_with(node, ParameterError, "no frame after that time")


class TestLockstep:
    def track(self, world: Any, source: Path, **tracker: Any) -> list[Any]:
        states = world.listen(JointState, "state")
        world.tracker(image_reliability="reliable", **tracker)
        node = world.replay(source=str(source), lockstep=True)
        play_to_the_end(world, node, states)
        return states

    @pytest.mark.parametrize("jpeg", [False, True])
    def test_every_frame_is_answered(self, world: Any, make_dive: Dive, jpeg: bool) -> None:
        transport = "compressed" if jpeg else "raw"
        states = self.track(world, make_dive(12, jpeg=jpeg), image_transport=transport)
        assert indices_of(states) == list(range(12))

    def test_a_recording_without_instruments_lets_no_frame_wait_for_them(
        self, world: Any, make_dive: Dive
    ) -> None:
        # The wait is longer than `answer_timeout`, after which the replay gives up.
        states = self.track(
            world, make_dive(3), instrument_reliability="reliable", instrument_wait=60.0
        )
        assert indices_of(states) == [0, 1, 2]

    def test_twice_the_same_recording_gives_the_same_estimates(
        self, world: Any, make_dive: Dive
    ) -> None:
        states = world.listen(JointState, "state")
        tracker = world.tracker(
            image_reliability="reliable",
            presence_to_track=0.0,
            presence_to_lose=0.0,
            evidence_to_track=-10.0,
            evidence_to_lose=-10.0,
            confirmation_time=0.0,
        )
        path = str(make_dive(10))
        for count in (10, 20):
            node = world.replay(source=path, lockstep=True)
            world.spin(lambda node=node: node.finished)
            world.spin(lambda count=count: len(states) == count)
            world.remove(node)
            tracker.on_reset(Trigger.Request(), Trigger.Response())
        assert any(state.position for state in states)
        assert states[:10] == states[10:]

    def test_refused_frames_are_answered_too(
        self, world: Any, make_dive: Dive, tmp_path: Path
    ) -> None:
        tiny = make_dive(3, size=(32, 32), name="tiny")
        states = self.track(world, tiny)
        assert len(states) == 3

    def test_a_lockstep_waits_for_the_tracker_to_start(self, world: Any, make_dive: Dive) -> None:
        node = world.replay(source=str(make_dive(3)), lockstep=True)
        world.pass_time(0.2)
        assert node.sent == 0
        states = world.listen(JointState, "state")
        world.tracker(image_reliability="reliable")
        play_to_the_end(world, node, states)

    def test_a_loop_in_lockstep_goes_on(self, world: Any, make_dive: Dive) -> None:
        states = world.listen(JointState, "state")
        world.tracker(image_reliability="reliable")
        world.replay(source=str(make_dive(3)), lockstep=True, loop=True)
        world.spin(lambda: len(states) >= 9)
        assert indices_of(states)[:9] == [0, 1, 2] * 3

    def test_an_answer_that_does_not_come_is_an_error(self, world: Any, make_dive: Dive) -> None:
        world.listen(Image, "image")
        world.me.create_publisher(JointState, "state", 10)
        node = world.replay(source=str(make_dive(3)), lockstep=True, answer_timeout=0.2)
        world.ends_with(node, RosError, r"no `state` came for frame 0 within 0\.2 s")

    def test_a_lockstep_without_a_tracker_ends_with_an_error(
        self, world: Any, make_dive: Dive
    ) -> None:
        node = world.replay(source=str(make_dive(3)), lockstep=True, answer_timeout=0.2)
        world.ends_with(node, RosError, r"no node subscribes to .*/image")

    def test_a_lockstep_without_answers_says_that_images_are_subscribed_to(
        self, world: Any, make_dive: Dive
    ) -> None:
        world.listen(Image, "image")
        node = world.replay(source=str(make_dive(3)), lockstep=True, answer_timeout=0.2)
        world.ends_with(node, RosError, r"subscribed to, but no node publishes .*/state")

    def test_a_lockstep_names_the_instruments_that_the_tracker_does_not_read(
        self, world: Any, vehicle_bag: Path
    ) -> None:
        for kind, topic in ((Image, "image"), (Imu, "imu"), (Odometry, "odometry")):
            world.listen(kind, topic)
        world.listen(CameraInfo, "camera_info")
        world.me.create_publisher(JointState, "state", qos.LATEST_RESULT)
        node = world.replay(source=str(vehicle_bag), lockstep=True, answer_timeout=0.2)
        world.ends_with(node, RosError, r"but not altitude; .* altitude_topic:=none")


def test_no_attribute_hides_one_of_rclpy(world: Any, make_dive: Dive) -> None:
    plain = set(vars(world.me))
    for node in (world.tracker(), world.replay(source=str(make_dive(1)), paused=True)):
        assert isinstance(node, type(world.me))
        for name in plain:
            assert type(vars(node)[name]) is type(vars(world.me)[name]), name


def test_a_lockstep_replay_ends_with_the_last_answer(world: Any, make_dive: Dive) -> None:
    states = world.listen(JointState, "state")
    world.tracker(image_reliability="reliable")
    # To wait for a fourth answer would take longer than the test may spin.
    node = world.replay(source=str(make_dive(3)), lockstep=True, answer_timeout=3600.0)
    world.spin(lambda: len(states) == 3)
    world.spin(lambda: node.finished)


def test_a_lockstep_waits_for_the_tracker_itself_to_hear_the_images(
    world: Any, make_dive: Dive
) -> None:
    world.listen(Image, "image")
    teller = world.add(Node("tracker", context=world.context, namespace=world.namespace))
    teller.create_publisher(JointState, "state", 1)
    node = world.replay(source=str(make_dive(3)), lockstep=True, answer_timeout=3600.0)
    world.spin(lambda: world.me.count_publishers(f"{world.namespace}/state"))
    world.pass_time(0.5)
    assert not node._subscribers.is_there
    teller.create_subscription(Image, "image", lambda _message: None, 1)
    world.spin(lambda: node._subscribers.is_there)


class SlowLink:
    """A publisher whose last messages take some looks to arrive."""

    def __init__(self, publisher: Any, looks: float) -> None:
        self._publisher = publisher
        self.looks = looks

    def __getattr__(self, name: str) -> Any:
        return getattr(self._publisher, name)

    def wait_for_all_acked(self, timeout: Any) -> bool:
        assert timeout.nanoseconds == 0, "a node that waits here hears no signal"
        self.looks -= 1
        return self.looks <= 0


class TestEnd:
    def test_a_replay_ends_when_the_last_frame_has_arrived(
        self, world: Any, make_dive: Dive
    ) -> None:
        node = world.replay(source=str(make_dive(2)), rate=100)
        node._image = SlowLink(node._image, 3)
        world.spin(lambda: node.finished)
        assert node._image.looks == 0

    def test_a_replay_ends_though_the_last_frame_never_arrives(
        self, world: Any, make_dive: Dive, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(endpoints, "LAST_MESSAGE_PATIENCE", 0.1)
        node = world.replay(source=str(make_dive(2)), rate=100)
        node._truth = SlowLink(node._truth, float("inf"))
        world.spin(lambda: node.finished)


class TestInstruments:
    @pytest.fixture
    def bag(self, vehicle_bag: Path) -> Path:
        return vehicle_bag

    def test_all_instruments_are_sent_as_recorded(self, world: Any, bag: Path) -> None:
        kinds = {
            "odometry": Odometry, "imu": Imu, "altitude": Range, "camera_info": CameraInfo,
            "fix": NavSatFix,
        }  # fmt: skip
        heard = {topic: world.listen(kind, topic) for topic, kind in kinds.items()}
        images = world.listen(Image, "image")
        node = world.replay(source=str(bag), rate=20.0)
        play_to_the_end(world, node, images)
        recorded = dict(open_bag(bag).topics)
        for topic in ("altitude", "camera_info"):
            world.spin(lambda topic=topic: len(heard[topic]) == recorded[f"/{topic}"].count)
        for messages in heard.values():
            assert messages
            assert stamps_of(messages) == sorted(stamps_of(messages))
        sent = [each.twist.twist.linear.x for each in heard["odometry"]]
        with open_source(bag) as recording:
            source = recorded_vehicle(recording).source
        stored = [
            each.message.twist.twist.linear.x
            for each in source.messages()
            if each.instrument is Instrument.ODOMETRY
        ]
        assert sent == stored[: len(sent)]

    def test_without_tf2_msgs_a_note_says_that_no_tracker_needs_it(
        self,
        world: Any,
        bag: Path,
        monkeypatch: pytest.MonkeyPatch,
        capfd: pytest.CaptureFixture[str],
    ) -> None:
        made = replay_instruments.message_class

        def without_tf(name: str) -> Any:
            if name == TF_TYPE:
                raise ImportError(name)
            return made(name)

        monkeypatch.setattr(replay_instruments, "message_class", without_tf)
        world.replay(source=str(bag), rate=20.0, instruments=True)
        assert replay_instruments.NO_STATIC_WORDS in capfd.readouterr().err

    def test_a_mounting_that_only_the_tracker_needs_is_not_asked_for(
        self, world: Any, make_dive: Dive, tmp_path: Path, capfd: pytest.CaptureFixture[str]
    ) -> None:
        vehicle = tmp_path / "vehicle.yaml"
        vehicle.write_text(
            "image_width: 160\nimage_height: 120\ndistortion_model: plumb_bob\n"
            "camera_matrix: [150, 0, 80, 0, 150, 60, 0, 0, 1]\n"
            "distortion_coefficients: [0, 0, 0, 0, 0]\n"
        )
        world.replay(source=str(make_dive(3)), instruments=True, vehicle=str(vehicle))
        said = capfd.readouterr().err
        assert "instruments: camera_info" in said
        assert "mounting" not in said

    def test_instruments_can_be_left_out(self, world: Any, bag: Path) -> None:
        heard, images = world.listen(Odometry, "odometry"), world.listen(Image, "image")
        node = world.replay(source=str(bag), rate=20.0, instruments=False)
        play_to_the_end(world, node, images)
        assert not heard

    def test_a_missing_topic_of_an_instrument_is_refused(self, world: Any, bag: Path) -> None:
        with pytest.raises(RecordingError, match="there is no topic /other"):
            world.replay(source=str(bag), imu_topic="/other")

    def test_the_calibration_of_a_vehicle_file_wins(
        self, world: Any, bag: Path, tmp_path: Path
    ) -> None:
        file = tmp_path / "mine.yaml"
        file.write_text(
            "image_width: 64\nimage_height: 48\ndistortion_model: plumb_bob\n"
            "camera_matrix: [77.0, 0.0, 31.5, 0.0, 77.0, 23.5, 0.0, 0.0, 1.0]\n"
            "distortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n"
        )
        heard, images = world.listen(CameraInfo, "camera_info"), world.listen(Image, "image")
        node = world.replay(source=str(bag), rate=20.0, vehicle=str(file))
        play_to_the_end(world, node, images)
        world.spin(lambda: len(heard) == len(images))
        # With every frame, as of a camera: a tracker that starts meanwhile has need of it, too.
        assert stamps_of(heard) == stamps_of(images)
        assert {message.k[0] for message in heard} == {77.0}
