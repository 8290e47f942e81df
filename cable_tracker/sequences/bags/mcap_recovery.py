"""Read an mcap from its beginning without index and footer, as far as it goes.

A recorder that crashed leaves no footer, and the file usually ends in the middle of a record. Such
an end is normal here. What cannot be the work of a crash is damage and said so: an impossible
record, a chunk whose checksum is wrong, a chunk that does not unpack.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import IO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Message, Schema

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_limits import MCAP_UNPACKERS
from cable_tracker.sequences.bags.bag_storage import StoredMessage

MAGIC = b"\x89MCAP0\r\n"
_ROS2_PROFILE = "ros2"
_ROS2_ENCODING = "cdr"
_START = struct.Struct("<8sBQI")
_LONGEST_PROFILE = 64
_FOOTER_RECORD = b"\x02\x14\x00\x00\x00\x00\x00\x00\x00"
_FOOTER_LENGTH = 37
_FIRST_PRIVATE_OPCODE = 0x80
_KNOWN_OPCODES = frozenset(int(opcode) for opcode in Opcode)
_LARGEST_RECORD = 1 << 30
_MESSAGE_HEADER = 22
_BLOCK = 1 << 20
_CHUNK_HEADER = struct.Struct("<QQQII")


class _CutOff(Exception):  # noqa: N818
    """The file ends in the middle of a record."""


@dataclass(frozen=True, slots=True)
class _Record:
    opcode: int
    content: bytes


def is_closed(path: Path) -> bool:
    """Tell whether an mcap ends with a footer, as a recorder leaves it that ended well."""
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - _FOOTER_LENGTH))
        end = file.read(_FOOTER_LENGTH)
    return end.startswith(_FOOTER_RECORD) and end.endswith(MAGIC)


def profile_of(path: Path) -> str:
    """Return the profile that an mcap states, "ros1" or "ros2"; empty: it states none."""
    with path.open("rb") as file:
        start, profile = file.read(_START.size), file.read(_LONGEST_PROFILE)
    if len(start) < _START.size:
        return ""
    magic, opcode, _, length = _START.unpack(start)
    is_mcap = magic == MAGIC and opcode == Opcode.HEADER
    return profile[:length].decode(errors="replace") if is_mcap else ""


def is_ros2_alone(path: Path) -> bool:
    """Tell whether an mcap that was closed says it is of ROS 2, and so are all of its channels.

    Raises
    ------
    Exception
        It is damaged; the library that parses records does not say what it raises then.
    """
    if profile_of(path) != _ROS2_PROFILE:
        return False
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(size - _FOOTER_LENGTH + len(_FOOTER_RECORD))
        (summary,) = struct.unpack("<Q", file.read(8))
        file.seek(summary or len(MAGIC))
        channels = (each for each in _records(file, size) if each.opcode == Opcode.CHANNEL)
        return all(_channel(each).message_encoding == _ROS2_ENCODING for each in channels)


def _channel(record: _Record) -> Channel:
    return Channel.read(ReadDataStream(BytesIO(record.content)))


def _damage(what: str, position: int) -> RecordingError:
    return RecordingError(f"{what} near byte {position}")


def _only_zeros(file: IO[bytes]) -> bool:
    while block := file.read(_BLOCK):
        if block.count(0) != len(block):
            return False
    return True


def _read_record_start(file: IO[bytes]) -> tuple[int, int] | None:
    """Read opcode and length of the next record; None at the end of the file.

    A file system that lost power may have filled the end of the file with zeros.
    """
    position = file.tell()
    start = file.read(9)
    if not start:
        return None
    opcode = start[0]
    if not opcode and not any(start) and _only_zeros(file):
        raise _CutOff
    if opcode not in _KNOWN_OPCODES and opcode < _FIRST_PRIVATE_OPCODE:
        raise _damage(f"a record of unknown kind {opcode}", position)
    if len(start) < 9:
        raise _CutOff
    (length,) = struct.unpack_from("<Q", start, 1)
    if length > _LARGEST_RECORD:
        raise _damage(f"a record of impossible length {length}", position)
    return opcode, length


def _unpack(compression: str, data: bytes, size: int) -> bytes:
    """Decompress what is there of a chunk, at most `size` bytes."""
    unpack = MCAP_UNPACKERS.get(compression)
    if unpack is None:
        raise ValueError(f"unknown compression {compression[:20]!r}")
    return unpack(data, size)[:size]


def _chunk_records(content: bytes, complete: bool, position: int) -> Iterator[_Record]:
    """Yield the records inside a chunk; of a chunk that was cut off, those that are there."""
    try:
        _, _, size, checksum, name_length = _CHUNK_HEADER.unpack_from(content)
        name_end = _CHUNK_HEADER.size + name_length
        compression = content[_CHUNK_HEADER.size : name_end].decode()
        unpacked = _unpack(compression, content[name_end + 8 :], size)
    except (struct.error, ValueError, RuntimeError, zstandard.ZstdError, MemoryError) as error:
        if not complete:
            raise _CutOff from error
        raise _damage("a chunk that cannot be unpacked", position) from error
    if complete and len(unpacked) != size:
        raise _damage("a chunk of wrong size", position)
    if complete and checksum and zlib.crc32(unpacked) != checksum:
        raise _damage("a chunk with a wrong checksum", position)
    try:
        yield from _records(BytesIO(unpacked), len(unpacked), inside_chunk=True)
    except _CutOff as error:
        if complete:
            raise _damage("a chunk that ends inside a record", position) from error
        raise
    if not complete:
        raise _CutOff


def _records(file: IO[bytes], size: int, *, inside_chunk: bool = False) -> Iterator[_Record]:
    """Yield the records of the data section, those in chunks too."""
    while start := _read_record_start(file):
        opcode, length = start
        if opcode in (Opcode.DATA_END, Opcode.FOOTER):
            return
        position = file.tell()
        complete = position + length <= size
        if opcode == Opcode.CHUNK and not inside_chunk:
            yield from _chunk_records(file.read(length), complete, position)
        elif not complete:
            raise _CutOff
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
            yield _Record(opcode, file.read(length))
        else:
            file.seek(length, 1)


def _messages(records: Iterator[_Record]) -> Iterator[StoredMessage]:
    schemas: dict[int, str] = {}
    channels: dict[int, tuple[str, str] | None] = {}
    for record in records:
        stream = ReadDataStream(BytesIO(record.content))
        if record.opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            schemas[schema.id] = schema.name
        elif record.opcode == Opcode.CHANNEL:
            channel = _channel(record)
            is_ros2 = channel.message_encoding == _ROS2_ENCODING
            kind = (channel.topic, schemas.get(channel.schema_id, ""))
            channels[channel.id] = kind if is_ros2 else None
        elif len(record.content) > _MESSAGE_HEADER:
            message = Message.read(stream, len(record.content))
            of_channel = channels[message.channel_id]
            if of_channel is not None:
                yield StoredMessage(*of_channel, message.log_time, message.data)


def read_messages(path: Path) -> Iterator[StoredMessage]:
    """Yield the messages of an mcap in the order of the file, until it ends or is cut off.

    Those that are not of ROS 2, such as JSON, are left out.

    Raises
    ------
    RecordingError
        The file is no mcap, or is damaged. The message is the reason alone, without the path.
    """
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(0)
        if not MAGIC.startswith(file.read(len(MAGIC))):
            raise RecordingError("it does not begin like an mcap file")
        try:
            yield from _messages(_records(file, size))
        except _CutOff:
            return
