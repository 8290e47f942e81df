from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cable_tracker.metric.frames import Mounting
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage, InstrumentSource
from cable_tracker.sequences.bags.instruments import TOPICS, Instrument
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages, ros1_typestore, typestore
from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.messages.static_transforms import pose_in
from cable_tracker.simulation.instruments.instrument_messages import (
    make_range,
    make_static_transforms,
)

FACTORY = RosbagsMessages()
RANGE = "sensor_msgs/msg/Range"
RECEIVED = 7_000_000_009


def instruments_of(path):
    return InstrumentSource(path, open_bag(path), "/image")


@pytest.fixture
def bag(tmp_path):
    path = tmp_path / "dive"
    with BagWriter(path) as writer:
        transforms = make_static_transforms(FACTORY, 1, 0.3)
        writer.write("/tf_static", "tf2_msgs/msg/TFMessage", transforms, 1)
        for stamp, received in ((10, 15), (20, 25), (0, 35)):
            message = make_range(FACTORY, make_header(FACTORY, stamp, "altimeter"), 2.0)
            writer.write("/altitude", RANGE, message, received)
    return path


def test_messages_come_with_both_of_their_times(bag):
    messages = list(instruments_of(bag).messages())
    assert [each.instrument for each in messages] == [Instrument.ALTITUDE] * 3
    assert [each.received for each in messages] == [15, 25, 35]
    assert [each.stamp for each in messages] == [10, 20, 35]


def test_messages_closer_than_the_given_interval_are_skipped(bag):
    source = instruments_of(bag)
    assert [each.received for each in source.messages({Instrument.ALTITUDE: 11})] == [15, 35]
    assert len(list(source.messages({Instrument.IMU: 11}))) == 3


def test_unreadable_messages_are_left_out_with_one_note_per_topic(tmp_path):
    path = tmp_path / "dive"
    with BagWriter(path) as writer:
        message = make_range(FACTORY, make_header(FACTORY, 10, "altimeter"), 2.0)
        writer.write("/altitude", RANGE, message, 15)
        for received in (25, 35):
            writer.write_serialised("/altitude", RANGE, b"\x00\x01\x00\x00\x07", received)
    source = instruments_of(path)
    assert source.remarks() == ()
    for _ in range(2):
        assert [each.received for each in source.messages()] == [15]
    (remark,) = source.remarks()
    assert remark.startswith("/altitude: 2 of its messages cannot be read and are left out (the")


def test_the_mounting_is_read_from_tf_static(bag):
    transforms = instruments_of(bag).static_transforms()
    rotation, origin = pose_in(transforms, "camera", "base_link")
    np.testing.assert_allclose(rotation, Mounting(pitch=math.pi / 2 - 0.3).rotation, atol=1e-12)
    np.testing.assert_allclose(origin, 0.0)


def of_ros1(name: str, **fields: Any) -> Any:
    types = ros1_typestore().types
    time = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    header = types["std_msgs/msg/Header"](seq=3, stamp=time, frame_id="sonar")
    return types[name](header=header, **fields)


def received(instrument: Instrument, message: Any) -> Any:
    """Return a message as ROS 2 gets it that was recorded by ROS 1, without a stamp."""
    sent = InstrumentMessage(instrument, message, RECEIVED, RECEIVED).as_ros2()
    type_name = TOPICS[instrument].type_name
    return typestore().deserialize_cdr(typestore().serialize_cdr(sent, type_name), type_name)


@pytest.mark.parametrize("seconds", [0, 5, 2**32 - 1])
def test_a_range_of_ros1_is_sent_with_the_stamp_that_it_counts_with(seconds: int) -> None:
    message = of_ros1(
        "sensor_msgs/msg/Range", radiation_type=0, field_of_view=0.1, min_range=0.2, max_range=9.0,
        range=2.5,
    )  # fmt: skip
    message.header.stamp.sec = seconds
    sent = received(Instrument.ALTITUDE, message)
    assert stamp_of(sent.header) == (5_000_000_000 if seconds == 5 else RECEIVED)
    assert sent.header.frame_id == "sonar"
    assert (sent.range, sent.max_range, sent.variance) == (2.5, 9.0, 0.0)


def test_a_number_is_sent_as_a_range_with_the_stamp_that_it_counts_with() -> None:
    sent = received(Instrument.ALTITUDE, typestore().types["std_msgs/msg/Float64"](data=1.5))
    assert (stamp_of(sent.header), sent.range, sent.min_range) == (RECEIVED, 1.5, 0.0)


def test_a_calibration_of_ros1_is_sent_under_the_names_of_ros2() -> None:
    region = ros1_typestore().types["sensor_msgs/msg/RegionOfInterest"]
    sent = received(
        Instrument.CAMERA_INFO,
        of_ros1(
            "sensor_msgs/msg/CameraInfo",
            height=48, width=64, distortion_model="plumb_bob",
            D=np.array([0.1, 0.0, 0.0, 0.0]), K=np.arange(9.0), R=np.zeros(9), P=np.arange(12.0),
            binning_x=2, binning_y=1, roi=region(1, 2, 3, 4, False),
        ),
    )  # fmt: skip
    assert list(sent.k) == list(range(9)) and list(sent.p) == list(range(12))
    assert (sent.d[0], sent.width, sent.binning_x, sent.roi.y_offset) == (0.1, 64, 2, 2)
