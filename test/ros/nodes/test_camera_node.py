"""What a camera, its clock and its link may do to a node that tracks, shown by that of cables."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any
from zlib import crc32

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image, JointState
from std_srvs.srv import SetBool, Trigger

from cable_tracker.cable.model.state import CableState
from cable_tracker.ros.nodes import tracker_node
from cable_tracker.sequences.messages.cable import read_state
from cable_tracker.sequences.pictures.picture_header import MAX_PIXELS

SECOND = 1_000_000_000
START = 1_700_000_000 * SECOND
FRAME = 40_000_000

Make = Callable[..., Any]


def stamped(message: Any, stamp: int) -> Any:
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, SECOND)
    return message


@pytest.fixture
def feed(world: Any, strip: Make, image_message: Make) -> Make:
    """Give a node the strip at some times [ns]; no two pictures are the same."""
    pictures: list[int] = []

    def fed(node: Any, stamps: list[int], **image: Any) -> None:
        for stamp in stamps:
            pixels = strip()
            pixels[0, 0] = len(pictures) % 256
            pictures.append(stamp)
            world.show(node, stamped(image_message(pixels, **image), stamp))

    return fed


def regular(count: int, start: int = START, step: int = FRAME) -> list[int]:
    return [start + index * step for index in range(count)]


class TestOneStamp:
    def test_a_repeated_stamp_is_refused_and_moves_nothing(
        self, world: Any, near: str, feed: Make
    ) -> None:
        node = world.tracker(initial_state=near)
        feed(node, regular(5))
        before = node.tracker.particles
        feed(node, [START + 4 * FRAME] * 3)
        assert (node.statistics.tracked, node.statistics.refused) == (5, 3)
        assert node.tracker.particles is before
        assert node.status == "TRACKING"

    def test_a_frame_without_a_stamp_has_the_time_at_which_it_came(
        self, world: Any, strip: Make, image_message: Make
    ) -> None:
        node = world.tracker()
        states = world.listen(JointState, "state")
        message = stamped(image_message(strip()), 0)
        waited = 3_000_000_000
        earliest = int(node.get_clock().now().nanoseconds) - waited
        info = {"received_timestamp": time.time_ns() - waited}
        latest = int(node.get_clock().now().nanoseconds) - waited
        node.on_image(serialize_message(message), info)
        world.spin(lambda: states)
        stamp = states[0].header.stamp.sec * 10**9 + states[0].header.stamp.nanosec
        assert states[0].header.frame_id == "eye"
        assert earliest - 100_000_000 < stamp < latest + 100_000_000


class TestStatus:
    def test_every_change_of_status_is_published_at_once(
        self,
        world: Any,
        near: str,
        strip: Make,
        image_message: Make,
        diagnostics: Make,
    ) -> None:
        node = world.tracker(initial_state=near, diagnostics_period=3600.0, input_timeout=3600.0)
        for index in range(18):
            picture = np.full((240, 320), 90, np.uint8) if index >= 5 else strip()
            world.show(node, image_message(picture, index=index))
        node.on_reset(Trigger.Request(), Trigger.Response())
        node.on_enable(SetBool.Request(data=False), SetBool.Response())
        expected = ["INITIALISING", "TRACKING", "LOST", "INITIALISING", "DISABLED"]
        # The first is sent before there is a subscriber.
        world.spin(lambda: [status for status, _ in diagnostics(node)][-4:] == expected[1:])

    def test_silence_is_stale_input_until_a_frame_comes(
        self, world: Any, image_message: Make, diagnostics: Make
    ) -> None:
        node = world.tracker(input_timeout=0.2)
        bottom = np.full((240, 320), 90, np.uint8)
        world.show(node, image_message(bottom))
        assert node.status == "INITIALISING"
        world.spin(lambda: node.status == "STALE INPUT")
        world.spin(lambda: diagnostics(node) and diagnostics(node)[-1][0] == "STALE INPUT")
        world.show(node, image_message(bottom, index=1))
        assert node.status == "INITIALISING"
        world.spin(lambda: diagnostics(node)[-1][0] == "INITIALISING")

    def test_the_first_frame_after_a_silence_publishes_only_its_own_status(
        self,
        world: Any,
        near: str,
        strip: Make,
        image_message: Make,
        diagnostics: Make,
    ) -> None:
        node = world.tracker(initial_state=near, diagnostics_period=3600.0, input_timeout=0.5)
        for index in range(8):
            world.show(node, image_message(strip(), index=index))
        world.spin(lambda: node.status == "STALE INPUT")
        world.spin(lambda: diagnostics(node)[-1][0] == "STALE INPUT")
        assert diagnostics(node)[-1][1]["presence [%]"] == ""
        told = len(diagnostics(node))
        world.show(node, image_message(np.full((240, 320), 90, np.uint8), index=2000))
        world.spin(lambda: len(diagnostics(node)) > told)
        assert diagnostics(node)[told][0] == "INITIALISING"

    def test_a_reset_does_not_make_a_frozen_camera_live(
        self, world: Any, near: str, image_message: Make
    ) -> None:
        node = world.tracker(initial_state=near, frozen_timeout=0.2)
        for index in range(12):
            world.show(node, image_message(index=index))
        assert node.status == "FROZEN INPUT"
        node.on_reset(Trigger.Request(), Trigger.Response())
        world.show(node, image_message(index=12))
        assert node.status == "FROZEN INPUT"

    def test_a_frozen_camera_is_not_live_by_a_frame_that_is_refused(
        self,
        world: Any,
        near: str,
        strip: Make,
        image_message: Make,
    ) -> None:
        node = world.tracker(initial_state=near, frozen_timeout=0.2)
        for index in range(10, 24):
            world.show(node, image_message(index=index))
        assert node.status == "FROZEN INPUT"
        # Just before the last frame that was used, as of a driver that starts anew.
        world.show(node, image_message(strip() // 2, index=13))
        assert node.statistics.refused == 1
        assert node.status == "FROZEN INPUT"
        world.show(node, image_message(strip(), index=24))
        world.show(node, image_message(strip() // 2, index=25))
        assert node.status != "FROZEN INPUT"

    def test_a_camera_that_never_sends_is_stale_input_too(self, world: Any) -> None:
        node = world.tracker(input_timeout=0.2)
        world.spin(lambda: node.status == "STALE INPUT")


@pytest.mark.slow
class TestStamps:
    def test_a_frame_that_was_overtaken_is_refused_and_moves_nothing(
        self, world: Any, near: str, feed: Make
    ) -> None:
        node = world.tracker(initial_state=near)
        feed(node, regular(5))
        before = node.tracker.particles
        feed(node, [START + 3 * FRAME + 1])
        assert "out of order" in node.statistics.last_bad_frame
        assert node.tracker.particles is before
        feed(node, [START + 5 * FRAME])
        assert node.status == "TRACKING"

    @pytest.mark.parametrize("back", [0.3, 7.0, 3600.0, 1.6e9])
    def test_a_jump_back_restarts_tracking_and_is_named(
        self, world: Any, near: str, feed: Make, back: float
    ) -> None:
        node = world.tracker(initial_state=near)
        feed(node, regular(5))
        feed(node, regular(2, START + 4 * FRAME - round(back * SECOND)))
        assert node.statistics.last_event.startswith("time went back by")
        assert node.statistics.refused == 0
        assert node.statistics.tracked == 7

    @pytest.mark.parametrize("forward", [5.5, 7200.0, 1e9 - 1])
    def test_a_jump_far_ahead_restarts_tracking_and_is_named(
        self, world: Any, near: str, feed: Make, forward: float
    ) -> None:
        node = world.tracker(initial_state=near, maximum_gap=5.0)
        feed(node, regular(5, START - SECOND * 10**9))
        feed(node, regular(2, START - SECOND * 10**9 + round(forward * SECOND)))
        assert node.statistics.last_event.startswith("no frame for")
        assert node.statistics.tracked == 7

    def test_the_longer_the_gap_the_wider_the_belief(
        self, world: Any, near: str, feed: Make
    ) -> None:
        spreads = []
        for gap in (FRAME, SECOND, 4 * SECOND):
            node = world.tracker(initial_state=near, filter="bootstrap", maximum_gap=5.0)
            feed(node, regular(5))
            blank = np.full((240, 320), 90, np.uint8)
            # Without borders the weights stay level: what is seen is the prediction.
            node.tracker.process(blank, START + 4 * FRAME + gap)
            spreads.append(node.tracker.particles.states[:, 0].std())
            assert node.statistics.last_event == ""
        assert spreads == sorted(spreads)
        assert spreads[2] > 2 * spreads[0]

    @pytest.mark.parametrize("rate", [1, 200])
    def test_slow_and_fast_cameras_are_tracked(
        self, world: Any, near: str, truth: CableState, feed: Make, rate: int
    ) -> None:
        # A belief that has had a second to spread says less about what it was about.
        node = world.tracker(initial_state=near, presence_to_track=0.3, presence_to_lose=0.01)
        states = world.listen(JointState, "state")
        feed(node, regular(12, step=SECOND // rate))
        world.spin(lambda: len(states) == 12)
        assert node.status == "TRACKING"
        last = read_state(states[-1])
        assert last is not None
        assert last.distance == pytest.approx(truth.distance, abs=2.0)

    def test_without_stamp_and_clock_a_frame_is_refused_until_simulated_time_begins(
        self, world: Any, feed: Make
    ) -> None:
        node = world.tracker(use_sim_time=True)
        states = world.listen(JointState, "state")
        feed(node, [0, 0])
        assert node.statistics.refused == 2
        assert "nothing has come on /clock" in node.statistics.last_bad_frame
        world.spin(lambda: len(states) == 2)
        clock = world.me.create_publisher(Clock, "/clock", 10)
        world.spin(clock.get_subscription_count)
        message = Clock()
        message.clock.sec = 5

        def simulated_time_runs() -> bool:
            clock.publish(message)
            return bool(node.get_clock().now().nanoseconds)

        world.spin(simulated_time_runs)
        feed(node, [0])
        assert node.statistics.tracked == 1
        world.spin(lambda: len(states) == 3)
        assert states[-1].header.stamp.sec == 5


@pytest.mark.slow
class TestSilence:
    def test_frames_that_are_all_refused_are_stale_input_too(
        self, world: Any, near: str, feed: Make, image_message: Make
    ) -> None:
        node = world.tracker(initial_state=near, input_timeout=0.3)
        feed(node, regular(5))
        assert node.status == "TRACKING"

        def refused() -> bool:
            world.show(node, image_message(encoding="mono7", index=100))
            return bool(node.status == "STALE INPUT")

        world.spin(refused)
        feed(node, regular(1, START + SECOND))
        assert node.status == "TRACKING"

    def test_no_centreline_comes_while_input_is_stale(
        self, world: Any, near: str, feed: Make
    ) -> None:
        node = world.tracker(initial_state=near, input_timeout=0.2)
        lines = world.listen(PoseWithCovarianceStamped, "centreline")
        world.spin(lambda: world.me.count_publishers("centreline"))
        feed(node, regular(5))
        world.spin(lambda: node.status == "STALE INPUT")
        world.empty_queues()
        count = len(lines)
        assert count > 0
        world.pass_time(0.3)
        assert len(lines) == count
        feed(node, regular(1, START + SECOND))
        world.spin(lambda: len(lines) == count + 1)


@pytest.mark.slow
class TestFrozenCamera:
    def frozen(self, node: Any, image_message: Make, stamps: list[int]) -> None:
        for stamp in stamps:
            node.on_image(serialize_message(stamped(image_message(), stamp)), {})

    def test_the_same_picture_is_no_measurement_after_a_time(
        self,
        world: Any,
        near: str,
        image_message: Make,
        diagnostics: Make,
    ) -> None:
        node = world.tracker(initial_state=near, frozen_timeout=1.0, input_timeout=3600.0)
        states = world.listen(JointState, "state")
        self.frozen(node, image_message, regular(40))
        assert node.status == "FROZEN INPUT"
        assert node.statistics.frozen == 40 - 25
        world.spin(lambda: len(states) == 40)
        assert states[24].position and not states[25].position and not states[39].position
        world.spin(lambda: diagnostics(node) and diagnostics(node)[-1][0] == "FROZEN INPUT")
        assert float(diagnostics(node)[-1][1]["same picture for [s]"]) >= 1.0

    def test_tracking_resumes_with_the_first_different_picture(
        self, world: Any, near: str, image_message: Make, feed: Make, diagnostics: Make
    ) -> None:
        node = world.tracker(initial_state=near, frozen_timeout=1.0, diagnostics_period=3600.0)
        self.frozen(node, image_message, regular(40))
        world.spin(lambda: diagnostics(node) and diagnostics(node)[-1][0] == "FROZEN INPUT")
        feed(node, regular(1, START + 40 * FRAME))
        assert node.status == "TRACKING"
        assert node.statistics.last_event == ""
        world.spin(lambda: diagnostics(node) and diagnostics(node)[-1][0] == "TRACKING")

    def test_a_repeated_frame_after_a_jump_of_the_clock_is_not_frozen(
        self, world: Any, near: str, image_message: Make
    ) -> None:
        node = world.tracker(initial_state=near, maximum_gap=3.0)
        self.frozen(node, image_message, [START, START + 100 * SECOND])
        assert node.statistics.frozen == 0
        assert node.statistics.last_event == "no frame for 100.000 s"

    def test_zero_switches_the_check_off(self, world: Any, near: str, image_message: Make) -> None:
        node = world.tracker(initial_state=near, frozen_timeout=0.0)
        self.frozen(node, image_message, regular(15, step=SECOND // 5))
        assert node.status == "TRACKING"
        assert node.statistics.frozen == 0


@pytest.mark.slow
class TestPictures:
    @pytest.mark.parametrize(
        ("grey", "words"), [(0, "the same (0 of 255)"), (255, "the same (255 of 255)")]
    )
    def test_black_and_white_lose_the_cable_and_are_named(
        self,
        world: Any,
        near: str,
        feed: Make,
        image_message: Make,
        said: Make,
        grey: int,
        words: str,
    ) -> None:
        node = world.tracker(initial_state=near, frozen_timeout=0.0)
        feed(node, regular(5))
        for stamp in regular(40, START + SECOND):
            world.show(node, stamped(image_message(np.full((240, 320), grey, np.uint8)), stamp))
        assert node.status == "LOST"
        assert node.statistics.refused == 0
        assert words in said(node, "picture")

    def test_too_many_pixels_are_refused_before_anything_is_decoded(
        self, world: Any, image_message: Make
    ) -> None:
        node = world.tracker()
        side = math.isqrt(MAX_PIXELS) + 1
        world.show(node, image_message(width=side, height=side, step=side))
        assert "more than the" in node.statistics.last_bad_frame

    def test_a_picture_file_that_claims_gigabytes_is_refused(
        self, world: Any, compressed_message: Make
    ) -> None:
        node = world.tracker(image_transport="compressed")
        message = compressed_message("png")
        data = bytearray(message.data)
        data[16:24] = (60_000).to_bytes(4, "big") * 2
        data[29:33] = crc32(data[12:29]).to_bytes(4, "big")
        message.data = bytes(data)
        world.show(node, message)
        assert "60000 x 60000 pixels, more than the" in node.statistics.last_bad_frame

    def test_a_change_of_encoding_keeps_the_estimate(
        self, world: Any, near: str, feed: Make, strip: Make, image_message: Make
    ) -> None:
        node = world.tracker(initial_state=near)
        feed(node, regular(5))
        colour = np.ascontiguousarray(np.dstack([strip()] * 3))
        world.show(node, stamped(image_message(colour, "bgr8"), START + 5 * FRAME))
        assert node.status == "TRACKING"
        assert node.statistics.last_event == ""


def camera_profile(
    reliability: ReliabilityPolicy = ReliabilityPolicy.BEST_EFFORT,
    durability: DurabilityPolicy = DurabilityPolicy.VOLATILE,
) -> QoSProfile:
    return QoSProfile(depth=5, reliability=reliability, durability=durability)


@pytest.mark.slow
class TestOverDds:
    @pytest.mark.parametrize("reliability", [*ReliabilityPolicy.__members__.values()][1:3])
    @pytest.mark.parametrize("durability", [*DurabilityPolicy.__members__.values()][1:3])
    def test_any_camera_is_heard_by_default(
        self,
        world: Any,
        image_message: Make,
        reliability: ReliabilityPolicy,
        durability: DurabilityPolicy,
    ) -> None:
        node = world.tracker()
        camera = world.me.create_publisher(Image, "image", camera_profile(reliability, durability))
        world.spin(camera.get_subscription_count)
        camera.publish(image_message())
        world.spin(lambda: node.statistics.tracked == 1)

    @pytest.mark.parametrize("encoding", ["mono8", "bgr8", "32FC1"])
    def test_a_serialised_image_is_tracked_like_its_message(
        self, world: Any, near: str, image_message: Make, strip: Make, encoding: str
    ) -> None:
        pixels = {
            "mono8": strip(),
            "bgr8": np.ascontiguousarray(np.dstack([strip()] * 3)),
            "32FC1": strip().astype(np.float32),
        }[encoding]
        messages = [image_message(pixels, encoding, index=index, padding=4) for index in range(4)]
        states = world.listen(JointState, "state")
        node = world.tracker(initial_state=near, image_reliability="reliable")
        camera = world.me.create_publisher(Image, "image", 10)
        world.spin(camera.get_subscription_count)
        for message in messages:
            camera.publish(message)
        world.spin(lambda: len(states) == 4)
        assert [state.header for state in states] == [message.header for message in messages]
        node.on_reset(None, SetBool.Response())
        for message in messages:
            world.show(node, message)
        world.spin(lambda: len(states) == 8)
        assert [list(each.position) for each in states[4:]] == [
            list(each.position) for each in states[:4]
        ]

    def test_only_the_newest_of_many_frames_is_used_and_the_others_are_counted(
        self, world: Any, image_message: Make
    ) -> None:
        node = world.tracker()
        states = world.listen(JointState, "state")
        camera = world.me.create_publisher(Image, "image", camera_profile())
        world.spin(camera.get_subscription_count)
        camera.publish(image_message(index=0))
        world.spin(lambda: len(states) == 1)
        # Nothing is spun here: as if the node were still busy with the first.
        for index in range(1, 21):
            camera.publish(image_message(index=index))
            time.sleep(0.001)
        world.spin(lambda: len(states) == 2)
        world.pass_time(0.1)
        assert len(states) == 2
        assert states[-1].header == image_message(index=20).header
        assert node.statistics.dropped == 19

    def test_a_reliable_input_answers_every_frame_of_a_burst(
        self, world: Any, image_message: Make
    ) -> None:
        node = world.tracker(image_reliability="reliable")
        states = world.listen(JointState, "state")
        camera = world.me.create_publisher(Image, "image", 10)
        world.spin(camera.get_subscription_count)
        for index in range(10):
            camera.publish(image_message(index=index))
        world.spin(lambda: len(states) == 10)
        assert node.statistics.dropped == 0

    def test_time_in_the_queue_counts_as_latency(self, world: Any, image_message: Make) -> None:
        node = world.tracker()
        camera = world.me.create_publisher(Image, "image", camera_profile())
        world.spin(camera.get_subscription_count)
        camera.publish(image_message())
        time.sleep(0.3)
        world.spin(lambda: node.statistics.tracked == 1)
        assert node.statistics.latency.latest[0] >= 250.0

    def test_bytes_that_are_no_image_are_refused(self, world: Any) -> None:
        node = world.tracker()
        node.on_image(b"\0\1\0\0\xff\xff", {})
        assert node.statistics.refused == 1
        assert "no sensor_msgs/Image" in node.statistics.last_bad_frame

    def test_bad_frames_over_dds_are_refused_and_the_next_is_tracked(
        self, world: Any, image_message: Make
    ) -> None:
        node = world.tracker(image_reliability="reliable")
        camera = world.me.create_publisher(Image, "image", 10)
        world.spin(camera.get_subscription_count)
        for index, changes in enumerate(({"step": 1}, {"data": b""}, {"encoding": "?" * 10_000})):
            camera.publish(image_message(index=index, **changes))
        camera.publish(image_message(index=9))
        world.spin(lambda: node.statistics.tracked == 1)
        assert node.statistics.refused == 3


class SlowWarmUp:
    """Runs as long as `running`, and ends with `error` if there is one."""

    seconds = 3.0

    def __init__(self) -> None:
        self.running = True
        self.error: Exception | None = None
        self.variants: list[Any] = []
        self.abandoned = 0

    def __call__(self, variant: Any, run: Any) -> SlowWarmUp:
        self.variants.append(variant)
        return self

    def abandon(self) -> None:
        self.abandoned += 1

    def finish(self) -> None:
        if self.error is not None:
            raise self.error


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> SlowWarmUp:
    """The warm-up of every node that is made, or changed, from now on."""
    warm_up = SlowWarmUp()
    monkeypatch.setattr(tracker_node, "WarmUp", warm_up)
    return warm_up


@pytest.mark.slow
class TestWarmUp:
    def test_no_frame_is_asked_for_before_the_node_is_warm(
        self, world: Any, slow: SlowWarmUp, diagnostics: Make
    ) -> None:
        node = world.cold_tracker(diagnostics_period=0.05)
        world.spin(lambda: diagnostics(node))
        assert diagnostics(node)[-1][0] == node.status == "WARMING UP"
        assert world.me.count_subscribers(f"{world.namespace}/image") == 0
        slow.running = False
        world.spin(lambda: world.me.count_subscribers(f"{world.namespace}/image") == 1)
        assert node.status == "INITIALISING"

    def test_a_change_that_needs_a_compilation_is_reported_and_keeps_the_estimate(
        self, world: Any, near: str, feed: Make, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        node = world.tracker(initial_state=near)
        feed(node, regular(5))
        slow = SlowWarmUp()
        monkeypatch.setattr(tracker_node, "WarmUp", slow)
        assert node.set_parameters([Parameter("resampling", value="stratified")])[0].successful
        assert node.status == "WARMING UP"
        states = world.listen(JointState, "state")
        feed(node, regular(1, START + 5 * FRAME))
        world.spin(lambda: len(states) == 1)
        assert not states[0].position
        assert node.statistics.ignored == 1
        slow.running = False
        world.spin(lambda: node.status != "WARMING UP")
        feed(node, regular(1, START + 6 * FRAME))
        assert node.status == "TRACKING"

    def test_a_change_during_the_first_warm_up_is_warmed_up_before_the_first_frame(
        self, world: Any, slow: SlowWarmUp
    ) -> None:
        node = world.cold_tracker()
        assert node.set_parameters([Parameter("filter", value="bootstrap")])[0].successful
        first, second = slow.variants
        assert "multi_hypothesis" in first and "bootstrap" in second
        assert slow.abandoned == 1
        assert node.status == "WARMING UP"
        slow.running = False
        world.spin(lambda: node.status == "INITIALISING")

    def test_an_error_of_the_compiler_is_not_hidden(self, world: Any, slow: SlowWarmUp) -> None:
        slow.error = ZeroDivisionError("no code")
        node = world.cold_tracker()
        slow.running = False
        with pytest.raises(ZeroDivisionError, match="no code"):
            node.on_watchdog()
        slow.error = None
