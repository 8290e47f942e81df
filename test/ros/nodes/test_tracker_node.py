from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from sensor_msgs.msg import CompressedImage, Image, JointState, PointCloud2
from std_msgs.msg import Header
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.ros.nodes import frame_outputs, tracker_node
from cable_tracker.sequences.messages import cable as cable_messages
from cable_tracker.sequences.messages.cable import cloud_of, read_particles, read_state
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.trackers import CableTracker

FRAMES = 4


@pytest.fixture
def track_strip(
    world: Any, near: str, image_message: Callable[..., Any]
) -> Callable[..., list[Any]]:
    """Let a node track frames of the strip, and return the states that it published."""

    def track(node: Any, frames: int = FRAMES, first: int = 0, **image: Any) -> list[Any]:
        states = world.listen(JointState, "state")
        for index in range(first, first + frames):
            world.show(node, image_message(index=index, **image))
        world.spin(lambda: len(states) == frames)
        return states

    return track


def assert_same_line(state: CableState | None, other: CableState) -> None:
    assert state is not None
    assert state.distance == pytest.approx(other.distance, abs=2.0)
    assert state.width == pytest.approx(other.width, abs=4.0)
    assert math.degrees(state.angle - other.angle) == pytest.approx(0.0, abs=2.0)


class TestEncodings:
    def test_encoding_byte_order_and_padding_are_those_of_the_message(
        self,
        world: Any,
        near: str,
        truth: CableState,
        strip: Callable[..., np.ndarray],
        track_strip: Callable[..., list[Any]],
    ) -> None:
        node = world.tracker(initial_state=near)
        # With their bytes swapped there is but noise.
        low = np.random.default_rng(0).integers(0, 256, strip().shape, np.uint16)
        pixels = strip().astype(np.uint16) * np.uint16(256) + low
        states = track_strip(node, pixels=pixels, encoding="mono16", bigendian=True, padding=12)
        assert_same_line(read_state(states[-1]), truth)

    def test_compressed_images_are_tracked(
        self,
        world: Any,
        near: str,
        truth: CableState,
        compressed_message: Callable[..., Any],
    ) -> None:
        node = world.tracker(initial_state=near, image_transport="compressed")
        states = world.listen(JointState, "state")
        for index in range(FRAMES):
            world.show(node, compressed_message(index=index))
        world.spin(lambda: len(states) == FRAMES)
        assert_same_line(read_state(states[-1]), truth)

    @pytest.mark.parametrize(
        ("transport", "topic", "kind"),
        [("raw", "image", Image), ("compressed", "image/compressed", CompressedImage)],
    )
    def test_the_transport_decides_which_topic_is_read(
        self,
        world: Any,
        image_message: Callable[..., Any],
        compressed_message: Callable[..., Any],
        transport: str,
        topic: str,
        kind: Any,
    ) -> None:
        node = world.tracker(image_transport=transport, image_reliability="reliable")
        publisher = world.me.create_publisher(kind, topic, 10)
        world.spin(publisher.get_subscription_count)
        message = image_message() if transport == "raw" else compressed_message()
        publisher.publish(message)
        world.spin(lambda: node.statistics.tracked == 1)


BAD_IMAGES = {
    "unknown encoding": ({"encoding": "mono7"}, "unknown encoding 'mono7'"),
    "tiny": ({"width": 1, "height": 1, "step": 1, "data": b"\x00"}, "too small"),
}
"""One that cannot be decoded, and one that cannot be tracked on."""


class TestBadFrames:
    @pytest.mark.parametrize("bad", BAD_IMAGES)
    def test_a_bad_image_is_refused_with_the_reason(
        self,
        world: Any,
        near: str,
        image_message: Callable[..., Any],
        said: Callable[..., str],
        track_strip: Callable[..., list[Any]],
        bad: str,
    ) -> None:
        changes, reason = BAD_IMAGES[bad]
        node = world.tracker(initial_state=near)
        states = track_strip(node, 3)
        before = node.tracker.particles
        world.show(node, image_message(index=3, **changes))
        world.spin(lambda: len(states) == 4)
        assert list(states[-1].name) == ["d", "alpha", "w", "beta"]
        assert not states[-1].position and not states[-1].velocity and not states[-1].effort
        assert states[-1].header == image_message(index=3).header
        assert node.statistics.refused == 1
        assert node.tracker.particles is before
        assert reason in said(node, "last bad frame")
        assert said(node, "frames refused") == "1"
        world.show(node, image_message(index=4))
        world.spin(lambda: len(states) == 5)
        assert read_state(states[-1]) is not None

    def test_a_stamp_beyond_the_last_second_is_refused_and_moves_nothing(
        self,
        world: Any,
        near: str,
        image_message: Callable[..., Any],
        track_strip: Callable[..., list[Any]],
    ) -> None:
        node = world.tracker(initial_state=near)
        states = track_strip(node, 3)
        before = node.tracker.particles
        message = image_message(index=3)
        message.header.stamp.sec, message.header.stamp.nanosec = 2**31 - 1, 10**9
        world.show(node, message)
        assert "check the clock" in node.statistics.last_bad_frame
        assert node.tracker.particles is before
        world.spin(lambda: len(states) == 4)
        assert states[-1].header == message.header and not states[-1].position

    def test_a_truncated_jpeg_is_refused(
        self, world: Any, compressed_message: Callable[..., Any]
    ) -> None:
        node = world.tracker(image_transport="compressed")
        states = world.listen(JointState, "state")
        world.show(node, compressed_message(length=-1000))
        world.spin(lambda: states)
        assert node.statistics.refused == 1
        assert not states[0].position
        world.show(node, compressed_message(index=1))
        assert node.statistics.tracked == 1

    @pytest.mark.parametrize(("sec", "nanosec"), [(-(2**31), 1), (2**31 - 1, 2**32 - 1)])
    def test_no_stamp_stops_the_node(
        self, world: Any, image_message: Callable[..., Any], sec: int, nanosec: int
    ) -> None:
        node = world.tracker()
        states = world.listen(JointState, "state")
        message = image_message()
        message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
        world.show(node, message)
        world.spin(lambda: states)
        assert states[0].header == message.header


def numbers_of(message: Any) -> list[float]:
    """Collect all numbers of a message, however deep."""
    if isinstance(message, (bool, int, float)):
        return [float(message)]
    if isinstance(message, (str, bytes)):
        return []
    if hasattr(message, "get_fields_and_field_types"):
        return [
            number
            for name in message.get_fields_and_field_types()
            for number in numbers_of(getattr(message, name))
        ]
    return [number for item in message for number in numbers_of(item)]


class TestTopics:
    def test_the_centreline_comes_only_while_tracking(
        self, world: Any, strip: Callable[..., np.ndarray], image_message: Callable[..., Any]
    ) -> None:
        node = world.tracker()
        states = world.listen(JointState, "state")
        lines = world.listen(PoseWithCovarianceStamped, "centreline")
        statuses = []
        for index in range(20):
            blank = np.full((240, 320), 90, np.uint8) if index >= 6 else strip()
            world.show(node, image_message(blank, index=index))
            statuses.append(node.status)
        world.spin(lambda: len(states) == 20)
        world.spin(lambda: len(lines) == statuses.count("TRACKING"))
        assert statuses[0] == "INITIALISING"
        assert "TRACKING" in statuses
        assert statuses[-1] == "LOST"
        tracking = {
            (state.header.stamp.sec, state.header.stamp.nanosec)
            for state, status in zip(states, statuses, strict=True)
            if status == "TRACKING"
        }
        assert {(line.header.stamp.sec, line.header.stamp.nanosec) for line in lines} == tracking
        for state, status in zip(states, statuses, strict=True):
            assert bool(state.position) == (status == "TRACKING")

    def test_state_and_particles_are_those_of_the_tracker_without_a_node(
        self,
        world: Any,
        near: str,
        strip: Callable[..., np.ndarray],
        stamp_of_index: Callable[[int], int],
        track_strip: Callable[..., list[Any]],
    ) -> None:
        tracker = CableTracker(TrackerParameters())
        tracker.initialise(GivenState.around(CableState(*map(float, near.split(",")))))
        clouds = world.listen(PointCloud2, "particles")
        states = track_strip(world.tracker(initial_state=near))
        world.spin(lambda: len(clouds) == FRAMES)
        for index, (state, cloud) in enumerate(zip(states, clouds, strict=True)):
            estimate = tracker.process(strip(), stamp_of_index(index))
            assert read_state(state) == estimate.state
            assert list(state.effort) == list(estimate.standard_deviations()[:4])
            assert np.array_equal(read_particles(cloud), cloud_of(tracker.particles).astype("f4"))

    def test_every_published_number_is_finite(
        self,
        world: Any,
        near: str,
        strip: Callable[..., np.ndarray],
        image_message: Callable[..., Any],
    ) -> None:
        node = world.tracker(initial_state=near, particle_count=50)
        heard = [
            world.listen(JointState, "state"),
            world.listen(PoseWithCovarianceStamped, "centreline"),
            world.listen(MarkerArray, "markers"),
        ]
        clouds = world.listen(PointCloud2, "particles")
        blanks = [np.full((240, 320), grey, np.uint8) for grey in (0, 128, 255)]
        pictures = [strip()] * 3 + blanks * 5 + [strip()[:, ::-1].copy()] * 3
        for index, picture in enumerate(pictures):
            world.show(node, image_message(picture, index=index))
        world.spin(lambda: len(heard[0]) == len(heard[2]) == len(clouds) == len(pictures))
        assert np.all(np.isfinite(numbers_of([message for topic in heard for message in topic])))
        assert all(np.all(np.isfinite(read_particles(cloud))) for cloud in clouds)

    def test_pictures_are_not_built_without_subscribers(
        self,
        world: Any,
        monkeypatch: pytest.MonkeyPatch,
        image_message: Callable[..., Any],
    ) -> None:
        node = world.tracker()
        builders = {
            "draw_estimate": tracker_node,
            "make_particles": cable_messages,
            "make_markers": cable_messages,
            "encode_jpeg": frame_outputs,
        }
        built: list[str] = []
        for name, module in builders.items():
            monkeypatch.setattr(module, name, spy(getattr(module, name), name, built))
        world.show(node, image_message())
        assert built == []
        topics = [(CompressedImage, "tracker/overlay/compressed"), (PointCloud2, "particles")]
        heard = [world.listen(*topic) for topic in [*topics, (MarkerArray, "markers")]]
        world.show(node, image_message(index=1))
        assert sorted(built) == sorted(builders)
        world.spin(lambda: all(heard))

    def test_messages_are_not_built_without_subscribers(
        self,
        world: Any,
        near: str,
        track_strip: Callable[..., list[Any]],
        monkeypatch: pytest.MonkeyPatch,
    ) -> None:
        built: list[Any] = []
        for name in ("make_centreline", "make_report"):
            monkeypatch.setattr(cable_messages, name, lambda *words, name=name: built.append(name))
        node = world.tracker(initial_state=near)
        track_strip(node)
        assert node.status == "TRACKING"
        assert built == []

    def test_the_overlay_is_drawn_once_for_both_its_topics(
        self, world: Any, monkeypatch: pytest.MonkeyPatch, image_message: Callable[..., Any]
    ) -> None:
        node = world.tracker()
        raw = world.listen(Image, "tracker/overlay")
        compressed = world.listen(CompressedImage, "tracker/overlay/compressed")
        built: list[str] = []
        drawn = spy(tracker_node.draw_estimate, "draw_estimate", built)
        monkeypatch.setattr(tracker_node, "draw_estimate", drawn)
        world.show(node, image_message())
        world.spin(lambda: raw and compressed)
        assert built == ["draw_estimate"]
        assert raw[0].encoding == "bgr8"
        assert raw[0].header == compressed[0].header == image_message().header
        assert bytes(compressed[0].data[:2]) == b"\xff\xd8"

    def test_a_change_of_the_image_size_restarts_tracking_and_is_reported(
        self,
        world: Any,
        strip: Callable[..., np.ndarray],
        image_message: Callable[..., Any],
        said: Callable[..., str],
    ) -> None:
        node = world.tracker()
        world.show(node, image_message())
        world.show(node, image_message(strip(size=(160, 120)), index=1))
        assert "from 320x240 to 160x120" in said(node, "last restart")


def spy(function: Callable[..., Any], name: str, calls: list[str]) -> Callable[..., Any]:
    def spied(*arguments: Any, **named: Any) -> Any:
        calls.append(name)
        return function(*arguments, **named)

    return spied


def prior_message(
    distance: float,
    yaw: float,
    *,
    variances: tuple[float, float, float] = (0.0, 0.0, 0.0),
    quaternion: tuple[float, float] | None = None,
    frame_id: str = "",
) -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped(header=Header(frame_id=frame_id))
    pose = message.pose.pose
    pose.position.x, pose.position.y = distance * math.cos(yaw), distance * math.sin(yaw)
    turn = (math.sin(yaw / 2), math.cos(yaw / 2)) if quaternion is None else quaternion
    pose.orientation.z, pose.orientation.w = turn
    covariance = np.zeros(36)
    covariance[[0, 7, 35]] = variances
    message.pose.covariance = covariance
    return message


OF_ANOTHER_FRAME = "initial_state refused: it is in 'map', not in the image frame 'eye'"


class TestInitialState:
    @pytest.mark.parametrize("turned", [0.0, math.pi, -math.pi])
    def test_the_filter_starts_at_the_foot_point_and_yaw(
        self,
        world: Any,
        truth: CableState,
        image_message: Callable[..., Any],
        turned: float,
    ) -> None:
        # That filter keeps the particles as they were drawn; the other draws about the best ones.
        node = world.tracker(filter="bootstrap")
        publisher = world.me.create_publisher(PoseWithCovarianceStamped, "initial_state", 10)
        world.spin(publisher.get_subscription_count)
        # The same line, with its normal to the other side.
        distance = truth.distance if turned == 0.0 else -truth.distance
        publisher.publish(prior_message(distance, truth.angle + turned))
        world.spin(lambda: node.tracker._given is not None)
        world.show(node, image_message())
        states = node.tracker.particles.states
        assert states[:, 0].mean() == pytest.approx(truth.distance, abs=1.0)
        assert states[:, 1].mean() == pytest.approx(truth.angle, abs=0.01)
        assert states[:, 0].std() < 4.0

    def test_unknown_variances_leave_the_component_open(
        self, world: Any, image_message: Callable[..., Any]
    ) -> None:
        node = world.tracker(filter="bootstrap")
        variances = (UNKNOWN_VARIANCE, UNKNOWN_VARIANCE, 1e-4)
        node.on_initial_state(prior_message(0.0, 0.3, variances=variances))
        world.show(node, image_message())
        states = node.tracker.particles.states
        assert states[:, 0].std() > 40.0
        assert states[:, 1].std() == pytest.approx(0.01, rel=0.3)

    def test_an_initial_state_is_logged_with_its_values(
        self, world: Any, capfd: pytest.CaptureFixture[str]
    ) -> None:
        node = world.tracker()
        node.on_initial_state(prior_message(12.0, 0.3))
        said = capfd.readouterr().err
        assert "[INFO]" in said
        assert "initial_state taken: d 12.0 px, alpha 0.300 rad" in said
        node.on_initial_state(prior_message(0.0, 0.3, variances=(*2 * [UNKNOWN_VARIANCE], 1e-4)))
        assert "initial_state taken: alpha 0.300 rad" in capfd.readouterr().err

    @pytest.mark.parametrize(
        "message",
        [
            prior_message(math.nan, 0.0),
            prior_message(1.0, 0.0, quaternion=(0.0, 0.0)),
        ],
    )
    def test_a_senseless_one_is_refused_with_a_warning(
        self,
        world: Any,
        message: PoseWithCovarianceStamped,
        image_message: Callable[..., Any],
        capfd: pytest.CaptureFixture[str],
    ) -> None:
        node = world.tracker()
        node.on_initial_state(message)
        assert "initial_state refused" in capfd.readouterr().err
        world.show(node, image_message())
        assert node.status == "INITIALISING"
        assert node.statistics.tracked == 1

    def test_an_initial_state_in_another_frame_is_refused(
        self, world: Any, image_message: Callable[..., Any], capfd: pytest.CaptureFixture[str]
    ) -> None:
        node = world.tracker()
        world.show(node, image_message())
        node.on_initial_state(prior_message(-90.0, 0.3, frame_id="map"))
        assert OF_ANOTHER_FRAME in capfd.readouterr().err
        assert node.tracker._given is None

    @pytest.mark.parametrize("enabled", [True, False])
    def test_an_initial_state_in_another_frame_than_the_first_image_is_dropped(
        self,
        world: Any,
        truth: CableState,
        near: str,
        image_message: Callable[..., Any],
        capfd: pytest.CaptureFixture[str],
        enabled: bool,
    ) -> None:
        node = world.tracker(initial_state=near, filter="bootstrap")
        node.on_enable(SetBool.Request(data=enabled), SetBool.Response())
        node.on_initial_state(prior_message(-90.0, 0.3, frame_id="map"))
        world.show(node, image_message())
        assert OF_ANOTHER_FRAME in capfd.readouterr().err
        node.on_enable(SetBool.Request(data=True), SetBool.Response())
        world.show(node, image_message(index=1))
        # What the parameter says is there again.
        mean = node.tracker.particles.states[:, 0].mean()
        assert mean == pytest.approx(truth.distance, abs=5.0)
        assert OF_ANOTHER_FRAME not in capfd.readouterr().err

    @pytest.mark.parametrize("frame_id", ["eye", ""])
    def test_the_last_one_before_the_first_image_counts(
        self,
        world: Any,
        truth: CableState,
        image_message: Callable[..., Any],
        capfd: pytest.CaptureFixture[str],
        frame_id: str,
    ) -> None:
        node = world.tracker(filter="bootstrap")
        node.on_initial_state(prior_message(-90.0, 0.3, frame_id="map"))
        node.on_initial_state(prior_message(truth.distance, truth.angle, frame_id=frame_id))
        world.show(node, image_message())
        assert "refused" not in capfd.readouterr().err
        assert node.tracker.particles.states[:, 0].std() < 4.0

    def test_an_initial_state_forgotten_by_a_reset_is_not_refused_later(
        self, world: Any, image_message: Callable[..., Any], capfd: pytest.CaptureFixture[str]
    ) -> None:
        node = world.tracker()
        node.on_initial_state(prior_message(-90.0, 0.3, frame_id="map"))
        node.on_reset(Trigger.Request(), Trigger.Response())
        world.show(node, image_message())
        assert "refused" not in capfd.readouterr().err

    def test_an_initial_state_sent_while_disabled_counts_when_enabled(
        self, world: Any, truth: CableState, image_message: Callable[..., Any]
    ) -> None:
        node = world.tracker(filter="bootstrap")
        node.on_enable(SetBool.Request(data=False), SetBool.Response())
        node.on_initial_state(prior_message(truth.distance, truth.angle))
        node.on_enable(SetBool.Request(data=True), SetBool.Response())
        world.show(node, image_message())
        assert node.tracker.particles.states[:, 0].std() < 4.0


class TestServicesAndStatus:
    def test_reset_starts_as_at_the_beginning(
        self, world: Any, near: str, track_strip: Callable[..., list[Any]]
    ) -> None:
        node = world.tracker(initial_state=near)
        first = [list(state.position) for state in track_strip(node)]
        response = world.call(Trigger, "tracker/reset")
        assert response.success and response.message
        assert node.status == "INITIALISING"
        again = [list(state.position) for state in track_strip(node)]
        assert first == again

    def test_a_disabled_node_answers_without_estimates(
        self, world: Any, image_message: Callable[..., Any], diagnostics: Callable[..., list[Any]]
    ) -> None:
        node = world.tracker()
        response = world.call(SetBool, "tracker/enable", data=False)
        assert response.success and response.message == "DISABLED"
        states = world.listen(JointState, "state")
        world.show(node, image_message())
        world.spin(lambda: states)
        assert not states[0].position
        assert node.tracker.particles is None
        assert node.statistics.ignored == 1
        world.spin(lambda: diagnostics(node) and diagnostics(node)[-1][0] == "DISABLED")
        world.call(SetBool, "tracker/enable", data=True)
        assert node.status == "INITIALISING"
        world.show(node, image_message(index=1))
        assert node.tracker.particles is not None

    def test_services_leave_a_line_in_the_log(
        self, world: Any, capfd: pytest.CaptureFixture[str]
    ) -> None:
        node = world.tracker()
        for call, words in (
            (lambda: node.on_enable(SetBool.Request(data=False), SetBool.Response()), "disabled:"),
            (lambda: node.on_enable(SetBool.Request(data=True), SetBool.Response()), "enabled:"),
            (lambda: node.on_reset(Trigger.Request(), Trigger.Response()), "reset:"),
        ):
            capfd.readouterr()
            call()
            assert words in capfd.readouterr().err

    def test_enabling_what_is_enabled_changes_nothing(
        self, world: Any, near: str, track_strip: Callable[..., list[Any]]
    ) -> None:
        node = world.tracker(initial_state=near)
        track_strip(node)
        assert world.call(SetBool, "tracker/enable", data=True).message == "TRACKING"
        assert node.tracker.particles is not None

    def test_a_reset_forgets_the_metres_too(
        self, world: Any, near: str, image_message: Callable[..., Any]
    ) -> None:
        node = world.tracker(initial_state=near)
        world.show(node, image_message())
        told = node._instruments.result
        node.on_reset(Trigger.Request(), Trigger.Response())
        assert node._instruments.result != told
        assert "no frame has come" in str(node._instruments.result)
