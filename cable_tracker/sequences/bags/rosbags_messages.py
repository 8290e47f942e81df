"""Messages as rosbags knows them: their definitions, made without ROS, and out of stored bytes."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from typing import Any

import numpy as np
import zstandard
from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.bags.bag_limits import LARGEST_UNPACKED, unpack_zstd
from cable_tracker.sequences.bags.bag_storage import StoredMessage
from cable_tracker.sequences.messages.factory import Message

_TAIL_LENGTHS = (4, 8)
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


@cache
def typestore() -> Typestore:
    """Return the messages of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


@cache
def ros1_typestore() -> Typestore:
    """Return the messages of ROS 1 Noetic."""
    return get_typestore(Stores.ROS1_NOETIC)


def add_definition(name: str, text: str) -> None:
    """Teach the store of ROS 2 a message type that is not one of ROS' own."""
    store = typestore()
    if name not in store.fielddefs:
        store.register(get_types_from_msg(text, name))


def _default_of_base(name: str) -> object:
    if name == "string":
        return ""
    if name == "bool":
        return False
    return 0.0 if name.startswith("float") else 0


def _default(definition: Any) -> object:  # noqa: ANN401
    # A definition is (kind, detail); the shape of the detail depends on the kind.
    kind, detail = definition
    if kind == Nodetype.BASE:
        return _default_of_base(detail[0])
    if kind == Nodetype.NAME:
        return RosbagsMessages().make(detail)
    element, count = detail
    if element[0] == Nodetype.BASE and element[1][0] != "string":
        dtype = {"octet": "uint8", "char": "uint8", "byte": "uint8"}.get(
            element[1][0], element[1][0]
        )
        return np.zeros(count if kind == Nodetype.ARRAY else 0, dtype=dtype)
    return [_default(element) for _ in range(count if kind == Nodetype.ARRAY else 0)]


class RosbagsMessages:
    """The `MessageFactory` of rosbags."""

    def make(self, type_name: str, /, **fields: object) -> Message:
        """Return a message; fields that are not given are zero or empty."""
        store = typestore()
        _, definitions = store.fielddefs[type_name]
        values: dict[str, Any] = {
            name: fields[name] if name in fields else _default(definition)
            for name, definition in definitions
        }
        return store.types[type_name](**values)

    def doubles(self, values: Sequence[float] | FloatArray) -> object:
        """Return the value of a field ``float64[]``."""
        return np.asarray(values, dtype=np.float64)

    def octets(self, data: bytes | memoryview) -> object:
        """Return the value of a field ``uint8[]``."""
        return np.frombuffer(data, dtype=np.uint8)

    def octet(self, value: int) -> object:
        """Return the value of a field ``byte``."""
        return value


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
    return _deserialise_cdr(data, message.msgtype)


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


def _deserialise_cdr(data: bytes, msgtype: str) -> object:
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
