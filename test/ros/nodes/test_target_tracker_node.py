from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest
from geometry_msgs.msg import (
    Point32,
    Polygon,
    PolygonStamped,
    PoseWithCovarianceStamped,
    Vector3Stamped,
)
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, PointCloud2
from std_msgs.msg import Header
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from cable_tracker.errors import ParameterError
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker

WATER, RED = (90, 80, 40), (30, 30, 200)
FRAMES = 8
BOX = "138.0,106.0,183.0,135.0"
FOCAL = 250.0


def scene(
    x: int | None = 160, y: int = 120, *, seed: int = 0, second: int | None = None
) -> np.ndarray:
    """Draw a red ellipse in even, noisy water; a second one at another column."""
    picture = np.full((240, 320, 3), WATER, np.uint8)
    for column in (x, second):
        if column is not None:
            cv2.ellipse(picture, (column, y), (22, 14), 0, 0, 360, RED, -1)
    noise = np.random.default_rng(seed).normal(0.0, 5.0, picture.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


def moving(index: int) -> np.ndarray:
    return scene(160 + 2 * index, 120 - index, seed=index)


@pytest.fixture
def show(world: Any, image_message: Callable[..., Any]) -> Callable[..., None]:
    def shown(node: Any, index: int, picture: np.ndarray | None = None) -> None:
        pixels = moving(index) if picture is None else picture
        encoding = "bgr8" if pixels.ndim == 3 else "mono8"
        world.show(node, image_message(pixels, encoding, index=index))

    return shown


@pytest.fixture
def follow(world: Any, show: Callable[..., None]) -> Callable[..., list[Any]]:
    """Show a node some frames, and return the states that it published."""

    def followed(node: Any, frames: int = FRAMES) -> list[Any]:
        states = world.listen(JointState, "state")
        for index in range(frames):
            show(node, index)
        world.spin(lambda: len(states) == frames)
        return states

    return followed


def polygon(*corners: tuple[float, float], frame_id: str = "eye") -> PolygonStamped:
    points = [Point32(x=float(x), y=float(y), z=0.0) for x, y in corners]
    return PolygonStamped(header=Header(frame_id=frame_id), polygon=Polygon(points=points))


def camera_info() -> CameraInfo:
    return CameraInfo(
        width=320, height=240, distortion_model="plumb_bob", d=[0.0] * 5,
        k=[FOCAL, 0.0, 159.5, 0.0, FOCAL, 119.5, 0.0, 0.0, 1.0],
    )  # fmt: skip


def corners_of(message: Any) -> np.ndarray:
    return np.array([(point.x, point.y) for point in message.polygon.points])


class TestTopics:
    def test_the_state_is_that_of_the_tracker_without_a_node(
        self, world: Any, follow: Callable[..., list[Any]], stamp_of_index: Callable[[int], int]
    ) -> None:
        tracker = TargetTracker(TargetParameters())
        tracker.initialise(TargetStart.from_box(*(float(side) for side in BOX.split(","))))
        states = follow(world.target_tracker(initial_target=BOX))
        for index, state in enumerate(states):
            estimate = tracker.process(moving(index), stamp_of_index(index))
            assert list(state.name) == ["x", "y", "size", "angle"]
            assert list(state.position[:2]) == list(estimate.state[:2])
            assert state.position[2] == math.sqrt(estimate.area)
            assert list(state.velocity) == [*estimate.state[4:], 0.0, 0.0]
            assert list(state.effort[:2]) == list(estimate.standard_deviations()[:2])

    def test_a_target_within_a_few_levels_of_a_deep_camera_is_followed_and_shown(
        self, world: Any, image_message: Callable[..., Any]
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        boxes = world.listen(PolygonStamped, "box")
        overlays = world.listen(Image, "target_tracker/overlay")
        for index in range(3):
            # 10 bits that are sent in 16.
            deep = 4 * moving(index).astype(np.uint16)
            world.show(node, image_message(deep, "bgr16", index=index))
        world.spin(lambda: len(boxes) == 3 and overlays)
        assert corners_of(boxes[-1]).mean(axis=0) == pytest.approx([164.5, 118.5], abs=3.0)
        assert np.mean(overlays[-1].data) > 60

    def test_centre_box_and_contour_are_where_the_target_is(
        self, world: Any, follow: Callable[..., list[Any]]
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        targets = world.listen(PoseWithCovarianceStamped, "target")
        boxes = world.listen(PolygonStamped, "box")
        contours = world.listen(PolygonStamped, "contour")
        states = follow(node)
        world.spin(lambda: min(len(targets), len(boxes), len(contours)) == FRAMES)
        last = FRAMES - 1
        place = targets[-1].pose.pose.position
        assert place.x == pytest.approx(160 + 2 * last - 159.5, abs=2.0)
        assert place.y == pytest.approx(119.5 - (120 - last), abs=2.0)
        assert targets[-1].header == states[-1].header
        covariance = np.array(targets[-1].pose.covariance).reshape(6, 6)
        assert list(np.diag(covariance)[2:5]) == [UNKNOWN_VARIANCE] * 3
        assert np.isfinite(covariance).all()
        box, contour = corners_of(boxes[-1]), corners_of(contours[-1])
        centre = [160.5 + 2 * last, 120.5 - last]
        assert box.mean(axis=0) == pytest.approx(centre, abs=3.0)
        assert np.ptp(box[:, 0]) == pytest.approx(45, abs=6)
        assert (contour >= box.min(axis=0) - 1).all() and (contour <= box.max(axis=0) + 1).all()

    def test_states_and_targets_are_published_only_while_tracking(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        states = world.listen(JointState, "state")
        targets = world.listen(PoseWithCovarianceStamped, "target")
        statuses = []
        for index in range(24):
            show(node, index, moving(index) if index < 8 else scene(None, seed=index))
            statuses.append(node.status)
        world.spin(lambda: len(states) == 24)
        world.spin(lambda: len(targets) == statuses.count("TRACKING"))
        assert statuses[7] == "TRACKING"
        assert statuses[-1] == "LOST"
        for state, status in zip(states, statuses, strict=True):
            assert bool(state.position) == (status == "TRACKING")

    def test_pictures_are_built_for_those_who_look(
        self, world: Any, follow: Callable[..., list[Any]]
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        clouds = world.listen(PointCloud2, "particles")
        markers = world.listen(MarkerArray, "markers")
        overlays = world.listen(Image, "target_tracker/overlay")
        follow(node)
        world.spin(lambda: clouds and markers and overlays)


class TestMarks:
    def test_a_box_on_the_topic_is_followed_from_the_next_frame(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        node = world.target_tracker()
        show(node, 0)
        assert node.status == "INITIALISING"
        node.on_initial_target(polygon((140, 105), (185, 134)))
        for index in range(1, 5):
            show(node, index)
        assert node.status == "TRACKING"

    def test_an_outline_on_the_topic_is_taken_as_it_is(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        node = world.target_tracker()
        turns = np.linspace(0.0, 2.0 * math.pi, 20)[:-1]
        outline = [(160.5 + 22 * math.cos(t), 120.5 + 14 * math.sin(t)) for t in turns]
        publisher = world.me.create_publisher(PolygonStamped, "initial_target", 10)
        world.spin(publisher.get_subscription_count)
        publisher.publish(polygon(*outline, frame_id=""))
        world.pass_time(0.3)
        for index in range(4):
            show(node, index)
        assert node.status == "TRACKING"

    @pytest.mark.parametrize(
        ("corners", "reason"),
        [
            (((400, 100), (460, 150)), "outside the picture"),
            ((), "two corners"),
        ],
    )
    @pytest.mark.parametrize("comes_first", [True, False])
    def test_a_mark_that_cannot_be_is_refused_with_the_reason(
        self,
        world: Any,
        show: Callable[..., None],
        said: Callable[..., str],
        corners: Any,
        reason: str,
        comes_first: bool,
    ) -> None:
        node = world.target_tracker()
        if not comes_first:
            show(node, 0)
        node.on_initial_target(polygon(*corners))
        for index in range(1, 3):
            show(node, index)
        assert node.status == "INITIALISING"
        assert node.statistics.refused == 0
        assert reason in said(node, "last restart")

    def test_a_mark_in_another_frame_is_refused(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        node = world.target_tracker()
        show(node, 0)
        node.on_initial_target(polygon((140, 105), (185, 134), frame_id="other"))
        show(node, 1)
        assert node.status == "INITIALISING"

    @pytest.mark.parametrize(
        ("parameter", "status"), [("wait", "INITIALISING"), ("140,105,185,134", "TRACKING")]
    )
    def test_a_mark_in_another_frame_than_the_first_image_is_dropped_with_it(
        self, world: Any, show: Callable[..., None], parameter: str, status: str
    ) -> None:
        node = world.target_tracker(initial_target=parameter)
        node.on_initial_target(polygon((20, 20), (60, 60), frame_id="other"))
        show(node, 0)
        assert "it is in 'other', not in the image frame 'eye'" in node.statistics.last_event
        for index in range(1, 4):
            show(node, index)
        assert node.status == status

    def test_a_target_that_does_not_stand_out_is_reported_and_not_claimed(
        self, world: Any, show: Callable[..., None], said: Callable[..., str]
    ) -> None:
        node = world.target_tracker(initial_target="20,20,60,60")
        for index in range(4):
            show(node, index)
        assert node.status == "INITIALISING"
        assert "stand out" in said(node, "last restart")

    def test_a_detector_proposes_where_it_is_asked_to(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        node = world.target_tracker(initial_target="detect")
        for index in range(6):
            show(node, index)
        assert node.status == "TRACKING"

    @pytest.mark.parametrize("text", ["here", "1,2,3", "10,10,10,50", "1,1,50,50;2,2,60,60"])
    def test_an_empty_start_is_refused_at_once(self, world: Any, text: str) -> None:
        with pytest.raises(ParameterError, match="initial_target"):
            world.target_tracker(initial_target=text)


class TestServices:
    def test_reset_goes_back_to_the_start_that_the_parameter_names(
        self, world: Any, follow: Callable[..., list[Any]], show: Callable[..., None]
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        follow(node, 4)
        node.on_initial_target(polygon((0, 0), (40, 40)))
        assert world.call(Trigger, "target_tracker/reset").success
        for index in range(4, 8):
            show(node, index, scene(seed=index))
        assert node.status == "TRACKING"

    def test_switched_off_it_claims_nothing_and_remembers_a_mark(
        self, world: Any, follow: Callable[..., list[Any]], show: Callable[..., None]
    ) -> None:
        node = world.target_tracker()
        states = follow(node, 2)
        assert world.call(SetBool, "target_tracker/enable", data=False).message == "DISABLED"
        show(node, 2)
        world.spin(lambda: len(states) == 3)
        assert not states[-1].position
        node.on_initial_target(polygon((144, 103), (189, 132)))
        assert world.call(SetBool, "target_tracker/enable", data=True).success
        for index in range(3, 7):
            show(node, index)
        assert node.status == "TRACKING"

    def test_a_box_that_was_changed_while_it_was_off_is_not_that_of_the_start(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        from rclpy.parameter import Parameter  # noqa: PLC0415

        node = world.target_tracker(initial_target="20,20,60,60")
        node.on_enable(SetBool.Request(data=False), SetBool.Response())
        (result,) = node.set_parameters([Parameter("initial_target", value=BOX)])
        assert result.successful
        node.on_enable(SetBool.Request(data=True), SetBool.Response())
        for index in range(4):
            show(node, index)
        assert node.status == "TRACKING"


class TestFrames:
    def test_a_frame_that_cannot_be_used_is_answered_and_changes_nothing(
        self,
        world: Any,
        follow: Callable[..., list[Any]],
        image_message: Callable[..., Any],
        show: Callable[..., None],
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        states = follow(node, 4)
        before = node.group.trackers[0].particles.states
        world.show(node, image_message(moving(4), "bgr8", index=4, step=3))
        world.spin(lambda: len(states) == 5)
        assert node.statistics.refused == 1
        assert not states[-1].position
        assert np.array_equal(node.group.trackers[0].particles.states, before)
        show(node, 5)
        assert node.status == "TRACKING"

    def test_frames_of_another_size_restart_tracking(
        self, world: Any, follow: Callable[..., list[Any]], show: Callable[..., None]
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        follow(node, 4)
        show(node, 4, np.ascontiguousarray(moving(4)[:200, :300]))
        assert node.status == "INITIALISING"
        assert "size changed" in node.statistics.last_event

    def test_colour_that_becomes_grey_is_followed_on(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        for index in range(16):
            picture = moving(index)
            # Of the red channel: in luma, red and this water hardly differ.
            show(node, index, picture if index < 5 else np.ascontiguousarray(picture[..., 2]))
        assert node.status == "TRACKING"


class TestMetres:
    def test_bearing_and_relative_pose_are_those_of_the_target(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        node = world.target_tracker(initial_target=BOX, target_size=0.5, camera_x=1.0)
        bearings = world.listen(Vector3Stamped, "bearing")
        poses = world.listen(PoseWithCovarianceStamped, "relative_pose")
        node._instruments.take_message(Instrument.CAMERA_INFO, camera_info())
        for index in range(6):
            show(node, index, scene(160, 120, seed=index))
        world.spin(lambda: len(bearings) == len(poses) == 6)
        ray = bearings[-1].vector
        assert (ray.x, ray.y, ray.z) == pytest.approx((0.0, 0.0, 1.0), abs=0.01)
        assert bearings[-1].header.frame_id == "eye"
        place = poses[-1].pose.pose.position
        # Root of the ellipse's area against the focal length.
        distance = 0.5 * FOCAL / math.sqrt(math.pi * 22 * 14)
        assert place.x == pytest.approx(1.0 + distance, rel=0.06)
        assert abs(place.y) < 0.05
        assert poses[-1].header.frame_id == "base_link"

    def test_without_a_calibration_the_reason_for_missing_metres_is_reported(
        self, world: Any, follow: Callable[..., list[Any]], said: Callable[..., str]
    ) -> None:
        node = world.target_tracker(initial_target=BOX)
        follow(node, 3)
        assert "no camera calibration" in said(node, "no metres")

    @pytest.mark.parametrize("instrument", ["odometry", "imu"])
    def test_turns_of_the_camera_are_taken_out(
        self, world: Any, show: Callable[..., None], instrument: str, header: Callable[..., Any]
    ) -> None:
        turn = 0.6
        shift = FOCAL * math.tan(turn * 0.04)
        node = world.target_tracker(initial_target="78,106,123,135", jump_share=0.0)
        node._instruments.take_message(Instrument.CAMERA_INFO, camera_info())
        for index in range(12):
            message = Odometry() if instrument == "odometry" else Imu()
            message.header = header(index)
            twist = message.twist.twist.angular if instrument == "odometry" else None
            (twist or message.angular_velocity).z = turn + 1e-6 * index
            node._instruments.take_message(Instrument(instrument), message)
            show(node, index, scene(round(100 + shift * index), seed=index))
        assert node.status == "TRACKING"
        assert node._instruments.fusion.unaided is None
        # The rates are those of the target itself, which hangs still in the water.
        rates = node.group.trackers[0].particles.states[:, 4]
        assert abs(np.median(rates)) < 0.3 * shift / 0.04

    def test_an_implausible_imu_moves_no_particle(
        self, world: Any, show: Callable[..., None], header: Callable[..., Any]
    ) -> None:
        node = world.target_tracker(initial_target="78,106,123,135")
        node._instruments.take_message(Instrument.CAMERA_INFO, camera_info())
        for index in range(6):
            message = Imu(header=header(index))
            message.angular_velocity.z = 1e200 if index == 4 else 1e-6 * index
            node._instruments.take_message(Instrument.IMU, message)
            show(node, index, scene(100, seed=index))
        assert (node.status, node.statistics.tracked) == ("TRACKING", 6)
        assert "infinite" in node._instruments.fusion.unaided.why

    def test_a_frame_waits_for_each_instrument_that_speaks(
        self, world: Any, show: Callable[..., None], header: Callable[..., Any]
    ) -> None:
        """Which of the two comes first must not decide whose motion is taken."""
        node = world.target_tracker(initial_target=BOX, instrument_wait=60.0)
        states = world.listen(JointState, "state")
        node._instruments.take_message(Instrument.CAMERA_INFO, camera_info())
        for instrument, kind in ((Instrument.IMU, Imu), (Instrument.ODOMETRY, Odometry)):
            node._instruments.take_message(instrument, kind(header=header(0)))
        show(node, 0)
        world.spin(lambda: len(states) == 1)
        node._instruments.take_message(Instrument.IMU, Imu(header=header(1)))
        show(node, 1)
        world.pass_time(0.2)
        assert len(states) == 1
        node._instruments.take_message(Instrument.ODOMETRY, Odometry(header=header(1)))
        world.spin(lambda: len(states) == 2)


class TestSeveral:
    def test_each_has_topics_of_its_own(self, world: Any, show: Callable[..., None]) -> None:
        boxes = "58,106,103,135;218,106,263,135"
        node = world.target_tracker(target_count=2, initial_target=boxes)
        heard = [world.listen(JointState, f"target_{number}/state") for number in range(2)]
        for index in range(6):
            show(node, index, scene(80 + index, second=240 - index, seed=index))
        world.spin(lambda: all(len(states) == 6 for states in heard))
        assert heard[0][-1].position[0] == pytest.approx(85 - 159.5, abs=3.0)
        assert heard[1][-1].position[0] == pytest.approx(235 - 159.5, abs=3.0)
        assert node.status == "TRACKING"

    def test_detectors_do_not_take_the_same_thing_twice(
        self, world: Any, show: Callable[..., None]
    ) -> None:
        node = world.target_tracker(target_count=2, initial_target="detect")
        heard = [world.listen(JointState, f"target_{number}/state") for number in range(2)]
        for index in range(8):
            show(node, index, scene(80 + index, second=240 - index, seed=index))
        world.spin(lambda: all(len(states) == 8 for states in heard))
        places = sorted(states[-1].position[0] for states in heard)
        assert places == pytest.approx([87 - 159.5, 233 - 159.5], abs=3.0)


class TestParameters:
    def test_presets_are_those_of_targets(self, world: Any) -> None:
        assert world.target_tracker(preset="diver").group.parameters.shape_rate == 0.25

    def test_changes_take_effect_and_bad_ones_are_refused_with_the_reason(self, world: Any) -> None:
        from rclpy.parameter import Parameter  # noqa: PLC0415

        node = world.target_tracker()
        good = node.set_parameters([Parameter("particle_count", value=77)])[0]
        assert good.successful
        assert node.group.parameters.particle_count == 77
        bad = node.set_parameters([Parameter("initial_target", value="4,4")])[0]
        assert not bad.successful and "box" in bad.reason
        both = [Parameter("presence_to_lose", value=0.99), Parameter("particle_count", value=5)]
        assert not node.set_parameters_atomically(both).successful
        assert node.group.parameters.particle_count == 77
