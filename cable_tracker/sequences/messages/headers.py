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


def nanoseconds_of(time: Message) -> int:
    """Return a time [ns]."""
    return int(time.sec) * NANOSECONDS + int(time.nanosec)


def stamp_of(header: Message) -> int:
    """Return a header's stamp [ns]."""
    return nanoseconds_of(header.stamp)


def stamp_or_received(message: Message, received: int) -> int:
    """Return the stamp of a message's header [ns]; where it has none, when it was received."""
    header = getattr(message, "header", None)
    return (stamp_of(header) if header is not None else 0) or received
