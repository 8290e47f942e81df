import math

import numpy as np
import pytest

from cable_tracker.metric.frames import Mounting
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.instrument_source import InstrumentSource
from cable_tracker.sequences.bags.instruments import (
    Instrument,
)
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.static_transforms import pose_in
from cable_tracker.simulation.instruments.instrument_messages import (
    make_range,
    make_static_transforms,
)

FACTORY = RosbagsMessages()
RANGE = "sensor_msgs/msg/Range"


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


def test_what_comes_sooner_after_another_than_is_asked_for_is_passed_over(bag):
    source = instruments_of(bag)
    assert [each.received for each in source.messages({Instrument.ALTITUDE: 11})] == [15, 35]
    assert len(list(source.messages({Instrument.IMU: 11}))) == 3


def test_messages_that_cannot_be_read_are_left_out_and_said_once_for_each_topic(tmp_path):
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
