"""Messages of the instruments in a bag of any kind, as ROS 2 writes and sends them."""

from __future__ import annotations

from collections.abc import Iterator
from heapq import merge

from cable_tracker.sequences.bags.convert import CarriedMessage
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage, InstrumentSource
from cable_tracker.sequences.bags.instruments import MOST_ALTITUDE, TOPICS, Instrument
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import is_given, make_header, stamp_of
from cable_tracker.sequences.messages.static_transforms import TF_STATIC, TF_TYPE


def carried_messages(source: InstrumentSource) -> Iterator[CarriedMessage]:
    """Yield what a converted bag holds besides pictures, on the topics of the recorded one."""
    static = (
        CarriedMessage(TF_STATIC, TF_TYPE, message, received)
        for received, message in source.static_messages()
    )
    readings = (
        CarriedMessage(
            source.found.topics[each.instrument],
            TOPICS[each.instrument].type_name,
            as_ros2(each),
            each.received,
        )
        for each in source.messages()
    )
    return merge(static, readings, key=lambda each: each.bag_time)


def as_ros2(given: InstrumentMessage) -> Message:
    """Return a recorded message in the type of ROS 2, with the stamp that it counts with."""
    message, factory = given.message, RosbagsMessages()
    type_name = TOPICS[given.instrument].type_name
    if not hasattr(message, "header"):
        # A number, which is an altitude.
        header = make_header(factory, given.stamp, "")
        number = float(message.data)
        return factory.make(type_name, header=header, max_range=MOST_ALTITUDE, range=number)
    if not is_given(stamp_of(message.header)):
        message.header = make_header(factory, given.stamp, str(message.header.frame_id))
    is_range = given.instrument is Instrument.ALTITUDE
    if hasattr(message, "K") or (is_range and not hasattr(message, "variance")):
        # ROS 1 names the matrices of a calibration by capitals, and knows no variance of a range.
        fields = {name.lower(): value for name, value in vars(message).items()}
        return factory.make(type_name, **fields)
    return message
