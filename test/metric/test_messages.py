from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Quaternion
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Imu, Range
from std_msgs.msg import Header

from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.messages import (
    METRES_KEYS,
    NO_METRES_KEY,
    TARGET_METRES_KEYS,
    WHY_NOT_KEY,
    cable_facts,
    has_bearing,
    has_metres,
    has_position,
    make_cross_track,
    read_attitude,
    read_camera_info,
    read_range,
    read_row_metres,
    read_twist,
    relative_messages,
    row_metres,
    target_facts,
)
from cable_tracker.metric.targets.relative_state import TargetSighting, begin_relative_state
from cable_tracker.metric.targets.target_metres import TargetMetres
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.instruments import MOST_ALTITUDE
from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE

K = [560.0, 0.0, 321.0, 0.0, 550.0, 238.0, 0.0, 0.0, 1.0]
P = [500.0, 0.0, 320.0, 0.0, 0.0, 501.0, 239.0, 0.0, 0.0, 0.0, 1.0, 0.0]

KNOWN = CrossTrack(0.1, 0.3, -0.7, 0.06, np.diag([0.02, 0.3, 1e-3, 0.1]), 2.0, -1.5)
NOT_KNOWN = Withheld(Reason.NO_ALTITUDE, "none has come on altitude")

NO_RANGE = Withheld(Reason.RANGE_UNKNOWN, "the target has not been seen as a whole yet")
RAY = np.array([0.0, 0.6, 0.8])
CAMERA_POSITION = np.array([0.5, 0.0, -0.1])


def camera_info(**fields: Any) -> CameraInfo:
    given = {"width": 640, "height": 480, "distortion_model": "plumb_bob", "k": K, "p": P}
    return CameraInfo(**{**given, "d": [0.1, -0.2, 0.0, 0.0, 0.05], **fields})


def test_a_raw_image_has_the_camera_matrix_and_the_lens() -> None:
    assert read_camera_info(camera_info(), is_rectified=False) == Calibration(
        (640, 480), "plumb_bob", (560.0, 550.0), (321.0, 238.0), (0.1, -0.2, 0.0, 0.0, 0.05)
    )


def test_a_rectified_image_has_the_projection_matrix_and_no_lens() -> None:
    assert read_camera_info(camera_info(), is_rectified=True) == Calibration(
        (640, 480), "plumb_bob", (500.0, 501.0), (320.0, 239.0)
    )


def test_region_and_binning_are_those_of_the_image() -> None:
    info = camera_info(binning_x=2, binning_y=2)
    info.roi.x_offset, info.roi.y_offset, info.roi.width, info.roi.height = 20, 40, 400, 300
    calibration = read_camera_info(info, is_rectified=False)
    assert calibration.image_size == (200, 150)
    assert calibration.focal == (280.0, 275.0)
    assert calibration.centre == (301.5 / 2 - 0.5, 198.5 / 2 - 0.5)


def test_a_camera_that_was_never_calibrated_can_be_read() -> None:
    assert read_camera_info(CameraInfo(), is_rectified=False).focal == (0.0, 0.0)


def test_a_range_has_its_limits() -> None:
    message = Range(range=1.5, min_range=0.25, max_range=30.0)
    assert read_range(message) == (1.5, (0.25, 30.0))
    assert read_range(Range(range=1.5)) == (1.5, (0.0, MOST_ALTITUDE))


@pytest.mark.parametrize("unset", [math.nan, math.inf, -math.inf])
def test_limits_of_a_range_that_are_no_numbers_are_not_set(unset: float) -> None:
    assert read_range(Range(range=1.5, min_range=unset, max_range=unset)) == (
        1.5, (0.0, MOST_ALTITUDE),
    )  # fmt: skip
    assert read_range(Range(range=1.5, min_range=unset, max_range=30.0)) == (1.5, (0.0, 30.0))


def imu(roll: float, **fields: Any) -> Imu:
    return Imu(orientation=Quaternion(x=math.sin(roll / 2), w=math.cos(roll / 2)), **fields)


def test_roll_comes_with_its_doubt() -> None:
    attitude = read_attitude(imu(0.2, orientation_covariance=[0.04, *[0.0] * 8]), 0.01)
    assert attitude is not None
    assert (attitude.roll, attitude.pitch) == pytest.approx((0.2, 0.0))
    assert attitude.sigma == pytest.approx(0.2)
    unsaid = read_attitude(imu(0.2), 0.01)
    assert unsaid is not None and unsaid.sigma == 0.01


@pytest.mark.parametrize(
    "message",
    [
        Imu(orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=0.0)),
        Imu(orientation=Quaternion(x=math.nan, w=1.0)),
        imu(0.2, orientation_covariance=[math.nan, *[0.0] * 8]),
    ],
    ids=["no quaternion", "no number", "no covariance"],
)
def test_an_unusable_orientation_is_no_attitude(message: Imu) -> None:
    attitude = read_attitude(message, 0.01)
    assert attitude is not None and not attitude.is_finite()


def test_an_imu_that_does_not_measure_its_orientation_says_nothing() -> None:
    assert read_attitude(imu(0.2, orientation_covariance=[-1.0, *[0.0] * 8]), 0.01) is None


@pytest.mark.parametrize("place", [0, 4], ids=["roll", "pitch"])
@pytest.mark.parametrize("variance", [1.0, 100.0, 9999.0, UNKNOWN_VARIANCE, math.inf])
def test_an_orientation_that_may_be_anything_is_not_measured(place: int, variance: float) -> None:
    covariance = [1e-4, *[0.0] * 3, 1e-4, *[0.0] * 4]
    covariance[place] = variance
    assert read_attitude(imu(0.2, orientation_covariance=covariance), 0.01) is None


def test_a_heading_that_may_be_anything_takes_nothing_from_roll_and_pitch() -> None:
    covariance = [1e-4, *[0.0] * 3, 1e-4, *[0.0] * 3, UNKNOWN_VARIANCE]
    attitude = read_attitude(imu(0.2, orientation_covariance=covariance), 0.001)
    assert attitude is not None and attitude.sigma == pytest.approx(0.01)


def test_offset_and_heading_stand_where_a_pose_has_them() -> None:
    covariance = np.array([[0.04, 0.001], [0.001, 0.01]])
    message = make_cross_track(
        RclpyMessages(), Header(frame_id="base_link"), (1.0, 0.3, -1.4), -0.2, covariance
    )
    assert message.header.frame_id == "base_link"
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    assert (position.x, position.y, position.z) == (1.0, 0.3, -1.4)
    assert 2 * math.atan2(orientation.z, orientation.w) == pytest.approx(-0.2)
    stated = np.array(message.pose.covariance).reshape(6, 6)
    np.testing.assert_array_equal(stated[np.ix_([1, 5], [1, 5])], covariance)
    assert (np.diag(stated)[[0, 2, 3, 4]] == UNKNOWN_VARIANCE).all()


def test_a_twist_comes_with_its_covariance() -> None:
    message = Odometry()
    message.twist.twist.linear.x, message.twist.twist.angular.z = 0.4, -0.2
    covariance = np.diag([0.04, 0.04, 0.0, 0.01, 0.01, 1e-9])
    covariance[0, 1] = covariance[1, 0] = 0.01
    covariance[1, 5] = covariance[5, 1] = 1e-6
    message.twist.covariance = covariance.ravel().tolist()
    twist, stated = read_twist(message, (0.1, 0.05))
    np.testing.assert_array_equal(twist, [0.4, 0.0, 0.0, 0.0, 0.0, -0.2])
    # What is not given, or implausibly small, is raised.
    np.testing.assert_allclose(np.diag(stated), [0.04, 0.04, 0.01, 0.01, 0.01, 0.0025])
    assert stated[0, 1] == stated[1, 0] == 0.01
    assert stated[1, 5] == stated[5, 1] == 0.0
    assert (np.linalg.eigvalsh(stated) > 0.0).all()


class TestTargetInMetres:
    RAY = np.array([0.0, 0.6, 0.8])
    CAMERA_PLACE = np.array([0.5, 0.0, -0.1])
    NOT_KNOWN = Withheld(Reason.RANGE_UNKNOWN, "the target has not been seen as a whole yet")

    def makers_of(self, metres: TargetMetres) -> Any:
        factory = RclpyMessages()
        header = make_header(factory, 1_700_000_000_123_456_789, "camera")
        return relative_messages(factory, header, "base", metres, self.CAMERA_PLACE)

    def test_the_bearing_is_of_the_camera_and_the_place_of_the_vehicle(self) -> None:
        state = begin_relative_state(TargetSighting(0.1, -0.2, 0.05, True), 0.4)
        makers = self.makers_of(TargetMetres(self.RAY, state))
        bearing, pose = makers[node_topics.BEARING](), makers[node_topics.RELATIVE_POSE]()
        assert (bearing.header.frame_id, pose.header.frame_id) == ("camera", "base")
        assert stamp_of(bearing.header) == stamp_of(pose.header) == 1_700_000_000_123_456_789
        position = pose.pose.pose.position
        assert [position.x, position.y, position.z] == list(state.position() + self.CAMERA_PLACE)

    def test_what_is_not_known_has_no_message(self) -> None:
        unknown = self.makers_of(TargetMetres(self.RAY, self.NOT_KNOWN))
        assert list(unknown) == [node_topics.BEARING]
        assert self.makers_of(TargetMetres(self.NOT_KNOWN, self.NOT_KNOWN)) == {}


def test_what_is_known_is_read_again_to_the_last_bit():
    facts = cable_facts(KNOWN)
    assert has_metres(facts)
    assert list(facts) == list(METRES_KEYS)
    assert read_row_metres(facts) == row_metres(KNOWN)


def test_nothing_known_gives_the_reason_alone():
    facts = cable_facts(NOT_KNOWN)
    assert facts == {NO_METRES_KEY: str(NOT_KNOWN)}
    assert not has_metres(facts)
    assert read_row_metres(facts) is None


def test_what_is_known_is_told_to_the_last_bit():
    state = begin_relative_state(TargetSighting(0.1, -0.2, 0.05, True), 0.4)
    facts = target_facts(TargetMetres(RAY, state), CAMERA_POSITION)
    assert has_bearing(facts)
    assert has_position(facts)
    assert list(facts) == [key for key in TARGET_METRES_KEYS if key != WHY_NOT_KEY]
    assert [float(facts[key]) for key in ("bearing_x", "bearing_y", "bearing_z")] == list(RAY)
    position = [float(facts[key]) for key in ("x", "y", "z")]
    assert position == list(state.position() + CAMERA_POSITION)
    assert float(facts["range"]) == state.range


def test_a_bearing_without_a_range_says_why_there_is_no_position():
    facts = target_facts(TargetMetres(RAY, NO_RANGE), CAMERA_POSITION)
    assert has_bearing(facts)
    assert not has_position(facts)
    assert facts[WHY_NOT_KEY] == str(NO_RANGE)


def test_of_a_target_without_metres_the_reason_alone_is_given():
    facts = target_facts(TargetMetres(NO_RANGE, NO_RANGE), CAMERA_POSITION)
    assert list(facts) == [WHY_NOT_KEY]
