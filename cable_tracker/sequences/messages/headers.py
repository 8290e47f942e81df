"""Times and headers."""

from __future__ import annotations

from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.stamps import NANOSECONDS


def make_time(factory: MessageFactory, stamp: int) -> Message:
    """Pack nanoseconds."""
    return factory.make(
        "builtin_interfaces/msg/Time", sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS
    )


def make_header(factory: MessageFactory, stamp: int, frame_id: str) -> Message:
    """Pack a stamp [ns] and a frame."""
    return factory.make("std_msgs/msg/Header", stamp=make_time(factory, stamp), frame_id=frame_id)


def stamp_of(header: Message) -> int:
    """Return a header's stamp [ns]."""
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)
