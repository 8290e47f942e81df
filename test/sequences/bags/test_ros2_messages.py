from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage, InstrumentSource
from cable_tracker.sequences.bags.instruments import TOPICS, Instrument
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.ros2_messages import as_ros2, carried_messages
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.bags.typestores import ros1_typestore, typestore
from cable_tracker.sequences.messages.headers import make_header, stamp_of

RECEIVED = 7_000_000_009


def of_ros1(name: str, **fields: Any) -> Any:
    types = ros1_typestore().types
    time = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    header = types["std_msgs/msg/Header"](seq=3, stamp=time, frame_id="sonar")
    return types[name](header=header, **fields)


def received(instrument: Instrument, message: Any) -> Any:
    """Return a message as ROS 2 gets it that was recorded by ROS 1, without a stamp."""
    sent = as_ros2(InstrumentMessage(instrument, message, RECEIVED, RECEIVED))
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


def test_instruments_and_mounting_are_carried_along_in_the_order_of_their_reception(
    tmp_path: Path,
) -> None:
    factory = RosbagsMessages()
    with BagWriter(tmp_path / "dive") as bag:
        for received, topic in ((5, "/dvl/odom"), (9, "/dvl/odom")):
            odometry = factory.make("nav_msgs/msg/Odometry", header=make_header(factory, 3, "odom"))
            bag.write(topic, "nav_msgs/msg/Odometry", odometry, received)
        bag.write("/tf_static", "tf2_msgs/msg/TFMessage", factory.make("tf2_msgs/msg/TFMessage"), 7)
        bag.write("/chatter", "std_msgs/msg/String", factory.make("std_msgs/msg/String"), 8)
    source = InstrumentSource(tmp_path / "dive", open_bag(tmp_path / "dive"), "/image")
    carried = list(carried_messages(source))
    assert [(each.topic, each.bag_time) for each in carried] == [
        ("/dvl/odom", 5), ("/tf_static", 7), ("/dvl/odom", 9),
    ]  # fmt: skip
    assert stamp_of(carried[0].message.header) == 3
