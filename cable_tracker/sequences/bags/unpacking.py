"""From the bytes of a stored message to a message object."""

from __future__ import annotations

from contextlib import suppress

import zstandard
from rosbags.serde import SerdeError

from cable_tracker.sequences.bags.bag_limits import LARGEST_UNPACKED, unpack_zstd
from cable_tracker.sequences.bags.bag_storage import StoredMessage
from cable_tracker.sequences.bags.typestores import ros1_typestore, typestore
from cable_tracker.sequences.messages.factory import Message

_TAIL_LENGTHS = (4, 8)
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


def deserialise(message: StoredMessage, *, is_ros1: bool) -> Message:
    """Deserialise a stored message, unpacking it first where the bag compresses messages.

    Raises
    ------
    Exception
        The bytes are no such message; the parser raises what it happens to raise.
    """
    data = message.data
    if _is_packed(data):
        data = unpack_zstd(data, _unpacked_size(data))
    if is_ros1:
        return ros1_typestore().deserialize_ros1(data, message.msgtype)
    return deserialise_cdr(data, message.msgtype)


def beginning(data: bytes, length: int) -> bytes:
    """Return the first bytes of a stored message, as it was before a bag compressed it.

    There may be more of them than `length`, and fewer where the message is short or damaged.
    """
    if not _is_packed(data):
        return data
    try:
        return unpack_zstd(data, length)
    except zstandard.ZstdError:
        return b""


def _is_packed(data: bytes) -> bool:
    """Tell whether a message was compressed by itself."""
    return data.startswith(_ZSTD_MAGIC)


def deserialise_cdr(data: bytes, msgtype: str) -> object:
    """Deserialise a ROS 2 message that may have a meaningless tail.

    rclpy's own serialiser leaves up to eight bytes at the end, and bags that are written with it
    hold them. rosbags passes over three.

    Raises
    ------
    SerdeError
        The bytes are no such message.
    """
    try:
        return typestore().deserialize_cdr(data, msgtype)
    except SerdeError:
        for length in _TAIL_LENGTHS:
            with suppress(SerdeError):
                return typestore().deserialize_cdr(data[:-length], msgtype)
        raise


def _unpacked_size(data: bytes) -> int:
    """Return the unpacked size that a zstd frame states; if it states none, the largest allowed."""
    size = zstandard.frame_content_size(data)
    return size if size >= 0 else LARGEST_UNPACKED
