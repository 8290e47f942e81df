from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages, typestore
from cable_tracker.sequences.node_topics import NodeTopic

FACTORY = RosbagsMessages()
TYPES = sorted(
    {topic.type_name for topic in vars(node_topics).values() if isinstance(topic, NodeTopic)}
)


@pytest.mark.parametrize(
    "type_name",
    [
        *TYPES,
        "sensor_msgs/msg/CameraInfo",
        "sensor_msgs/msg/Range",
        "sensor_msgs/msg/NavSatFix",
        "visualization_msgs/msg/Marker",
        "rcl_interfaces/msg/ParameterValue",
    ],
)
def test_a_message_with_nothing_given_is_empty_and_can_be_written_and_read(type_name):
    message = FACTORY.make(type_name)
    data = typestore().serialize_cdr(message, type_name)
    again = typestore().deserialize_cdr(data, type_name)
    assert typestore().serialize_cdr(again, type_name) == data


def test_fields_that_are_given_are_taken():
    header = FACTORY.make("std_msgs/msg/Header", frame_id="camera")
    message = FACTORY.make("sensor_msgs/msg/Image", header=header, width=7)
    assert (message.header.frame_id, message.width, message.height) == ("camera", 7, 0)
    assert message.header.stamp.sec == 0
    assert message.encoding == ""


def test_arrays_of_fixed_length_are_full_of_zeros():
    pose = FACTORY.make("geometry_msgs/msg/PoseWithCovariance")
    np.testing.assert_array_equal(pose.covariance, np.zeros(36))
    assert pose.covariance.dtype == np.float64


def test_lists_become_arrays_of_the_right_type():
    assert FACTORY.doubles([1, 2.5]).dtype == np.float64
    assert FACTORY.octets(memoryview(b"\x01\xff")).tolist() == [1, 255]
    assert FACTORY.octets(b"").tolist() == []
    assert FACTORY.octet(2) == 2


def test_two_messages_share_nothing():
    first, second = (FACTORY.make("visualization_msgs/msg/MarkerArray") for _ in range(2))
    first.markers.append(FACTORY.make("visualization_msgs/msg/Marker"))
    assert second.markers == []
