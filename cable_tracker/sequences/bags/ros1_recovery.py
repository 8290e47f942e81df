"""Read a ROS 1 bag from its beginning, without the index at its end."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import IO

from rosbags.typesys.msg import normalize_msgtype

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_limits import ROS1_UNPACKERS
from cable_tracker.sequences.bags.bag_storage import StoredMessage
from cable_tracker.stamps import NANOSECONDS

_MAGIC = b"#ROSBAG V2.0\n"
_MESSAGE, _CHUNK, _CONNECTION = 2, 5, 7
_LARGEST_HEADER = 1 << 24
_LARGEST_CHUNK = 1 << 30


def _read_exactly(file: IO[bytes], length: int) -> bytes:
    if length > _LARGEST_CHUNK:
        raise ValueError(f"a record of {length} bytes")
    data = file.read(length)
    if len(data) < length:
        raise EOFError("the file ends inside a record")
    return data


def _read_length(file: IO[bytes]) -> int:
    (length,) = struct.unpack("<I", _read_exactly(file, 4))
    return int(length)


def _fields(data: bytes) -> dict[bytes, bytes]:
    fields: dict[bytes, bytes] = {}
    position = 0
    while position < len(data):
        (length,) = struct.unpack_from("<I", data, position)
        name, _, value = data[position + 4 : position + 4 + length].partition(b"=")
        fields[name] = value
        position += 4 + length
    return fields


def _records(file: IO[bytes]) -> Iterator[tuple[dict[bytes, bytes], bytes]]:
    """Yield header and data of each record; of a chunk that was cut off, the records inside."""
    while start := file.read(4):
        (length,) = struct.unpack("<I", start)
        if length > _LARGEST_HEADER:
            raise ValueError(f"a header of {length} bytes")
        header = _fields(_read_exactly(file, length))
        length = _read_length(file)
        if header[b"op"][0] == _CHUNK:
            data = file.read(min(length, _LARGEST_CHUNK))
            unpack = ROS1_UNPACKERS[header[b"compression"].decode()]
            yield from _records(BytesIO(unpack(data)))
            if len(data) < length:
                raise EOFError("the file ends inside a chunk")
        else:
            yield header, _read_exactly(file, length)


def _messages(file: IO[bytes]) -> Iterator[StoredMessage]:
    connections: dict[bytes, tuple[str, str]] = {}
    for header, data in _records(file):
        kind = header[b"op"][0]
        if kind == _CONNECTION:
            msgtype = normalize_msgtype(_fields(data)[b"type"].decode())
            connections[header[b"conn"]] = (header[b"topic"].decode(), msgtype)
        elif kind == _MESSAGE:
            seconds, nanoseconds = struct.unpack("<II", header[b"time"])
            yield StoredMessage(
                *connections[header[b"conn"]], seconds * NANOSECONDS + nanoseconds, data
            )


def read_messages(path: Path) -> Iterator[StoredMessage]:
    """Yield the messages of a ROS 1 bag in the order of the file, up to the damage.

    Raises
    ------
    RecordingError
        Where the damage is. The message is the reason alone, without the path.
    """
    with path.open("rb") as file:
        if file.read(len(_MAGIC)) != _MAGIC:
            raise RecordingError("it does not begin like a ROS 1 bag")
        try:
            yield from _messages(file)
        except (EOFError, LookupError, ValueError, RuntimeError, OSError, struct.error) as error:
            raise RecordingError(f"{type(error).__name__}: {error}") from error
