"""Limits of unpacked sizes, enforced where rosbags trusts the sizes that a bag states.

A few kilobytes can unpack to gigabytes. A bag that does is refused before it takes memory or disk.
"""

from __future__ import annotations

import bz2
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from shutil import disk_usage
from typing import Protocol

import zstandard
from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]
from rosbags.rosbag1 import reader as rosbag1_reader
from rosbags.rosbag2 import storage_mcap

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.storage_files import METADATA, PACKED_SUFFIX

LARGEST_UNPACKED = 1 << 28
"""A chunk or message of more bytes is refused; the largest picture that is read has fewer."""

LARGEST_OVERLAP = 1 << 30
"""Chunks of one time, which rosbags unpacks all at once, may not have more bytes together."""

LARGEST_METADATA = 1 << 24
"""Bytes of a bag's metadata; a recorder writes some kilobytes."""

BLOCK = 1 << 20
FREE_SHARE = 0.5
"""Share of the free space for temporary files that unpacked files may take."""


class Chunk(Protocol):
    """Size and position of a chunk of an mcap."""

    message_start_time: int
    message_end_time: int
    uncompressed_size: int


def _too_large() -> RecordingError:
    return RecordingError(
        f"a part of it unpacks to more than {LARGEST_UNPACKED >> 20} MB, which no recorder writes"
    )


def unpack_zstd(data: bytes, size: int) -> bytes:
    """Decompress zstd, at most `size` bytes and one more, which tells that there are more.

    Raises
    ------
    RecordingError
        More than `LARGEST_UNPACKED` bytes are asked for.
    zstandard.ZstdError
        The data is damaged.
    """
    if size > LARGEST_UNPACKED:
        raise _too_large()
    with zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True) as reader:
        return reader.read(size + 1)


def unpack_lz4(data: bytes, size: int | None = None) -> bytes:
    """Decompress an lz4 frame; as `unpack_zstd`.

    Raises
    ------
    RecordingError
        It holds more than `LARGEST_UNPACKED` bytes, or more are asked for.
    RuntimeError
        The data is damaged.
    """
    wanted = LARGEST_UNPACKED if size is None else size
    if wanted > LARGEST_UNPACKED:
        raise _too_large()
    unpacked = bytes(LZ4FrameDecompressor().decompress(data, max_length=wanted + 1))
    if len(unpacked) > LARGEST_UNPACKED:
        raise _too_large()
    return unpacked


def unpack_bz2(data: bytes) -> bytes:
    """Decompress bz2.

    Raises
    ------
    RecordingError
        It holds more than `LARGEST_UNPACKED` bytes.
    OSError
        The data is damaged.
    """
    unpacked = bz2.BZ2Decompressor().decompress(data, LARGEST_UNPACKED + 1)
    if len(unpacked) > LARGEST_UNPACKED:
        raise _too_large()
    return unpacked


def _as_it_is(data: bytes, _size: int = 0) -> bytes:
    return data


MCAP_UNPACKERS: Mapping[str, Callable[[bytes, int], bytes]] = {
    "": _as_it_is,
    "lz4": unpack_lz4,
    "zstd": unpack_zstd,
}
ROS1_UNPACKERS: Mapping[str, Callable[[bytes], bytes]] = {
    "none": _as_it_is,
    "bz2": unpack_bz2,
    "lz4": unpack_lz4,
}


@cache
def limit_rosbags() -> None:
    """Let rosbags unpack chunks with our functions; its own know no limit, nor an option for one.

    Done before the first bag is opened, for all readers of the process.

    Raises
    ------
    RuntimeError
        This version of rosbags has other tables of functions.
    """
    mcap, ros1 = storage_mcap.DECOMPRESSORS, rosbag1_reader.decompressors
    if set(mcap) != set(MCAP_UNPACKERS) or set(ros1) != set(ROS1_UNPACKERS):
        raise RuntimeError("rosbags unpacks in other ways by now; see bag_limits.py")
    mcap.update(MCAP_UNPACKERS)
    ros1.update(ROS1_UNPACKERS)


def check_overlap(chunks: Iterable[Chunk]) -> None:
    """Check that the chunks of one time are not too much at once.

    Raises
    ------
    RecordingError
        They are.
    """
    edges = sorted(
        edge
        for chunk in chunks
        for edge in (
            (chunk.message_start_time, 0, chunk.uncompressed_size),
            (chunk.message_end_time, 1, -chunk.uncompressed_size),
        )
    )
    held = 0
    for _, _, change in edges:
        held += change
        if held > LARGEST_OVERLAP:
            raise RecordingError(
                f"its chunks hold more than {LARGEST_OVERLAP >> 20} MB of the same time"
            )


def check_folder(path: Path) -> None:
    """Check the metadata of a bag folder, and the files that rosbags would unpack to the disk.

    Raises
    ------
    RecordingError
        They are too large.
    """
    metadata = path / METADATA
    if metadata.is_file() and metadata.stat().st_size > LARGEST_METADATA:
        raise RecordingError(f"{metadata.name} has more than {LARGEST_METADATA >> 20} MB")
    room = room_to_unpack()
    for file in sorted(path.iterdir()):
        if file.suffix.lower() == PACKED_SUFFIX and file.is_file():
            room -= sum(map(len, unpacked_blocks(file, room)))


def room_to_unpack() -> int:
    """Return the space for unpacking into temporary files [bytes]."""
    return int(disk_usage(tempfile.gettempdir()).free * FREE_SHARE)


def unpacked_blocks(path: Path, room: int) -> Iterator[bytes]:
    """Yield what a compressed file holds.

    Raises
    ------
    RecordingError
        It holds more than `room` bytes.
    zstandard.ZstdError
        It is damaged.
    """
    size = 0
    with path.open("rb") as file:
        reader = zstandard.ZstdDecompressor().stream_reader(file, read_across_frames=True)
        while block := reader.read(BLOCK):
            size += len(block)
            if size > room:
                raise RecordingError(
                    f"{path.name} unpacks to more than {room >> 20} MB, half of the free space for"
                    " temporary files; unpack it elsewhere with: zstd -d"
                )
            yield block
