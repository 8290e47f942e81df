"""Times and headers."""

from __future__ import annotations

from cable_tracker.errors import FrameError
from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.stamps import NANOSECONDS

_SECONDS = 2**31
"""A message can represent this many seconds before and after zero."""


def is_representable(stamp: int) -> bool:
    """Tell whether the fields of a message can hold a time [ns].

    Headers that are received may hold a later one: their nanoseconds may exceed a second.
    """
    return -_SECONDS <= stamp // NANOSECONDS < _SECONDS


def check_stamp(stamp: int) -> None:
    """Check that the fields of a message can hold a time [ns].

    Raises
    ------
    FrameError
        They cannot.
    """
    if not is_representable(stamp):
        raise FrameError(
            f"the stamp {stamp / NANOSECONDS:.3f} s is none that a message has room for; check the"
            " clock of the camera"
        )


def make_time(factory: MessageFactory, stamp: int) -> Message:
    """Pack nanoseconds.

    Raises
    ------
    FrameError
        The fields of the message cannot hold the time.
    """
    check_stamp(stamp)
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


def is_given(stamp: int) -> bool:
    """Tell whether a recorded stamp [ns] is a time: neither 0 nor what no message can hold."""
    return bool(stamp) and is_representable(stamp)


def stamp_or_received(message: Message, received: int) -> int:
    """Return the stamp of a message's header [ns], or the time of reception where it gives none."""
    header = getattr(message, "header", None)
    stamp = stamp_of(header) if header is not None else 0
    return stamp if is_given(stamp) else received
