import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_storage import Topic
from cable_tracker.sequences.bags.instruments import (
    NO_TOPIC,
    Instrument,
    InstrumentChoice,
    find_instruments,
)

RANGE, INFO, ODOMETRY = (
    "sensor_msgs/msg/Range",
    "sensor_msgs/msg/CameraInfo",
    "nav_msgs/msg/Odometry",
)
IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


def topics_of(**topics: str) -> dict[str, Topic]:
    return {"/" + name.replace("__", "/"): Topic(kind, 3) for name, kind in topics.items()}


def find(topics: dict[str, Topic], **chosen: str):
    choice = InstrumentChoice({Instrument(name): topic for name, topic in chosen.items()})
    return find_instruments(topics, "/front/camera/image", choice)


def test_instruments_are_found_by_their_types():
    found = find(topics_of(depth_below=RANGE, dvl__odom=ODOMETRY))
    assert found.topics == {Instrument.ALTITUDE: "/depth_below", Instrument.ODOMETRY: "/dvl/odom"}
    assert not found.notes


def test_ambiguous_topics_are_not_chosen_but_noted():
    found = find(topics_of(port=RANGE, starboard=RANGE))
    assert not found.topics
    assert "--altitude-topic" in found.notes[0] and "/starboard" in found.notes[0]


def test_the_user_chooses_among_several():
    found = find(topics_of(port=RANGE, starboard=RANGE), altitude="starboard")
    assert found.topics == {Instrument.ALTITUDE: "/starboard"} and not found.notes


def test_an_instrument_can_be_left_out():
    assert not find(topics_of(port=RANGE), altitude=NO_TOPIC).topics


def test_the_calibration_beside_the_images_is_chosen():
    listed = topics_of(front__camera__camera_info=INFO, stern__camera__camera_info=INFO)
    assert find(listed).topics == {Instrument.CAMERA_INFO: "/front/camera/camera_info"}


def test_the_only_calibration_is_not_taken_from_beside_the_images_of_another_camera():
    listed = topics_of(
        front__camera__image=IMAGE, down__image_raw__compressed=COMPRESSED, down__camera_info=INFO
    )
    found = find(listed)
    assert not found.topics
    (note,) = found.notes
    assert note.startswith("/down/camera_info is not read: it stands beside the images of another")
    assert "--camera-info-topic (node: camera_info_topic)" in note
    chosen = find(listed, camera_info="/down/camera_info")
    assert chosen.topics == {Instrument.CAMERA_INFO: "/down/camera_info"} and not chosen.notes


@pytest.mark.parametrize("images", [{}, {"down__image_raw": IMAGE}])
def test_the_only_calibration_may_lie_where_there_are_no_images(images):
    listed = topics_of(front__camera__image=IMAGE, calibration__used=INFO, **images)
    assert find(listed).topics == {Instrument.CAMERA_INFO: "/calibration/used"}


def test_images_and_their_other_transports_have_one_calibration():
    listed = topics_of(
        front__camera__image=IMAGE, front__camera__image__compressed=COMPRESSED,
        front__camera__camera_info=INFO,
    )  # fmt: skip
    assert find(listed).topics == {Instrument.CAMERA_INFO: "/front/camera/camera_info"}


def test_a_ground_truth_topic_is_no_instrument():
    assert not find(topics_of(ground_truth__odometry=ODOMETRY)).topics


def test_a_missing_topic_is_refused_with_the_existing_ones():
    with pytest.raises(RecordingError, match=r"no topic below for altitude; choose one of /port"):
        find(topics_of(port=RANGE), altitude="below")


def test_a_topic_of_another_type_is_refused():
    with pytest.raises(RecordingError, match="is of type nav_msgs/msg/Odometry"):
        find(topics_of(odom=ODOMETRY), altitude="odom")


def test_a_topic_of_plain_numbers_is_an_altitude_only_on_request():
    listed = topics_of(height="std_msgs/msg/Float32")
    assert not find(listed).topics
    assert find(listed, altitude="height").topics == {Instrument.ALTITUDE: "/height"}
