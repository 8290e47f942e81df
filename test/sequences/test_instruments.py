import math

import numpy as np
import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bag_storage import Topic
from cable_tracker.sequences.bag_writer import BagWriter
from cable_tracker.sequences.instruments import (
    NO_TOPIC,
    Instrument,
    InstrumentChoice,
    InstrumentSource,
    StaticTransform,
    find_instruments,
    place_in,
)
from cable_tracker.sequences.messages import make_header
from cable_tracker.sequences.rosbags_messages import RosbagsMessages
from cable_tracker.simulation.instrument_messages import (
    make_range,
    make_static_transforms,
    optical_rotation,
)

FACTORY = RosbagsMessages()
RANGE, INFO, ODOMETRY = (
    "sensor_msgs/msg/Range",
    "sensor_msgs/msg/CameraInfo",
    "nav_msgs/msg/Odometry",
)


class Listed:
    """Topics without a bag."""

    def __init__(self, **topics: str) -> None:
        self.topics = {
            "/" + name.replace("__", "/"): Topic(kind, 3) for name, kind in topics.items()
        }


def find(listed: Listed, **chosen: str):
    choice = InstrumentChoice({Instrument(name): topic for name, topic in chosen.items()})
    return find_instruments(listed, "/front/camera/image", choice)


def test_instruments_are_found_by_their_types():
    found = find(Listed(depth_below=RANGE, dvl__odom=ODOMETRY))
    assert found.topics == {Instrument.ALTITUDE: "/depth_below", Instrument.ODOMETRY: "/dvl/odom"}
    assert not found.notes


def test_of_several_none_is_guessed():
    found = find(Listed(port=RANGE, starboard=RANGE))
    assert not found.topics
    assert "--altitude-topic" in found.notes[0] and "/starboard" in found.notes[0]


def test_the_user_chooses_among_several():
    found = find(Listed(port=RANGE, starboard=RANGE), altitude="starboard")
    assert found.topics == {Instrument.ALTITUDE: "/starboard"} and not found.notes


def test_the_user_may_leave_one_out():
    assert not find(Listed(port=RANGE), altitude=NO_TOPIC).topics


def test_of_several_calibrations_the_one_beside_the_images_counts():
    listed = Listed(front__camera__camera_info=INFO, stern__camera__camera_info=INFO)
    assert find(listed).topics == {Instrument.CAMERA_INFO: "/front/camera/camera_info"}


def test_what_is_known_as_truth_is_no_instrument():
    assert not find(Listed(ground_truth__odometry=ODOMETRY)).topics


def test_a_topic_that_is_not_there_is_said_with_those_that_are():
    with pytest.raises(RecordingError, match=r"no topic below for altitude; choose one of /port"):
        find(Listed(port=RANGE), altitude="below")


def test_a_topic_of_another_type_is_refused():
    with pytest.raises(RecordingError, match="is of type nav_msgs/msg/Odometry"):
        find(Listed(odom=ODOMETRY), altitude="odom")


def test_a_plain_number_is_an_altitude_if_the_user_says_so():
    listed = Listed(height="std_msgs/msg/Float32")
    assert not find(listed).topics
    assert find(listed, altitude="height").topics == {Instrument.ALTITUDE: "/height"}


@pytest.fixture
def bag(tmp_path):
    path = tmp_path / "dive"
    with BagWriter(path) as writer:
        transforms = make_static_transforms(FACTORY, 1, optical_rotation(0.3))
        writer.write("/tf_static", "tf2_msgs/msg/TFMessage", transforms, 1)
        for stamp, received in ((10, 15), (20, 25), (0, 35)):
            message = make_range(FACTORY, make_header(FACTORY, stamp, "altimeter"), 2.0)
            writer.write("/altitude", RANGE, message, received)
    return path


def test_messages_come_with_both_of_their_times(bag):
    messages = list(InstrumentSource(bag, "/image").messages())
    assert [each.instrument for each in messages] == [Instrument.ALTITUDE] * 3
    assert [each.received for each in messages] == [15, 25, 35]
    assert [each.stamp for each in messages] == [10, 20, 35]


def test_what_comes_sooner_after_another_than_is_asked_for_is_passed_over(bag):
    source = InstrumentSource(bag, "/image")
    assert [each.received for each in source.messages({Instrument.ALTITUDE: 11})] == [15, 35]
    assert len(list(source.messages({Instrument.IMU: 11}))) == 3


def test_messages_that_cannot_be_read_are_left_out_and_said_once_for_each_topic(tmp_path):
    path = tmp_path / "dive"
    with BagWriter(path) as writer:
        message = make_range(FACTORY, make_header(FACTORY, 10, "altimeter"), 2.0)
        writer.write("/altitude", RANGE, message, 15)
        for received in (25, 35):
            writer.write_serialised("/altitude", RANGE, b"\x00\x01\x00\x00\x07", received)
    source = InstrumentSource(path, "/image")
    assert source.remarks() == ()
    for _ in range(2):
        assert [each.received for each in source.messages()] == [15]
    (remark,) = source.remarks()
    assert remark.startswith("/altitude: 2 of its messages cannot be read and are left out (the")


def test_the_mounting_is_read_from_tf_static(bag):
    transforms = InstrumentSource(bag, "/image").static_transforms()
    rotation, place = place_in(transforms, "camera", "base_link")
    np.testing.assert_allclose(rotation, optical_rotation(0.3), atol=1e-12)
    np.testing.assert_allclose(place, 0.0)


def about_z(angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def test_transforms_are_followed_over_several_frames_up_and_down():
    chain = (
        StaticTransform("base", "arm", about_z(0.2), np.array([1.0, 0.0, 0.0])),
        StaticTransform("arm", "camera", about_z(0.3), np.array([0.0, 2.0, 0.0])),
        StaticTransform("base", "sonar", about_z(-0.1), np.array([0.0, 0.0, -1.0])),
    )
    rotation, place = place_in(chain, "camera", "base")
    np.testing.assert_allclose(rotation, about_z(0.5), atol=1e-12)
    np.testing.assert_allclose(place, about_z(0.2) @ [0.0, 2.0, 0.0] + [1.0, 0.0, 0.0])
    turned, _ = place_in(chain, "camera", "sonar")
    np.testing.assert_allclose(turned, about_z(0.6), atol=1e-12)


def test_frames_that_are_not_connected_have_no_place():
    chain = (StaticTransform("map", "other", np.eye(3), np.zeros(3)),)
    assert place_in(chain, "camera", "base") is None


def test_frames_that_hang_on_each_other_end():
    chain = (
        StaticTransform("a", "b", np.eye(3), np.zeros(3)),
        StaticTransform("b", "a", np.eye(3), np.zeros(3)),
    )
    assert place_in(chain, "a", "c") is None
