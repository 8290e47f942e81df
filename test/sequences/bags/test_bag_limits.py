"""An untrusted recording takes no memory or disk without bound, and has an end."""

from __future__ import annotations

import bz2
import sqlite3
import subprocess
import sys
import tracemalloc
from collections import namedtuple
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags import bag_limits
from cable_tracker.sequences.bags.bag_limits import (
    check_folder,
    check_overlap,
    unpack_bz2,
    unpack_lz4,
    unpack_zstd,
)
from cable_tracker.sequences.bags.storage_files import storage_files
from cable_tracker.sequences.source import open_source

MEGABYTE = 1 << 20
BOMB = 24 * MEGABYTE
Chunk = namedtuple("Chunk", "message_start_time message_end_time uncompressed_size")


@pytest.fixture
def small_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits that a test can pass without taking gigabytes itself."""
    monkeypatch.setattr(bag_limits, "LARGEST_UNPACKED", MEGABYTE)
    monkeypatch.setattr(bag_limits, "LARGEST_METADATA", MEGABYTE)


def read(path: Path) -> None:
    with open_source(path, skip_bad_frames=True) as source:
        for _ in source.frames():
            pass


def peak_memory(action: Callable[[], None]) -> int:
    tracemalloc.start()
    try:
        action()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def mcap_bomb(path: Path, compression: CompressionType) -> Path:
    writer = McapWriter(str(path), compression=compression, chunk_size=2 * BOMB)
    writer.start("ros2")
    schema = writer.register_schema("sensor_msgs/msg/Image", "ros2msg", b"uint8[] data")
    channel = writer.register_channel("/image", "cdr", schema)
    writer.add_message(channel, 1, bytes(BOMB), 1)
    writer.finish()
    return path


def refuse(path) -> None:
    with pytest.raises(RecordingError, match="unpacks to more than 1 MB"):
        read(path)


@pytest.mark.usefixtures("small_limits")
@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
@pytest.mark.parametrize("crashed", [False, True])
def test_a_chunk_that_unpacks_to_very_much_takes_no_memory(tmp_path, compression, crashed):
    path = mcap_bomb(tmp_path / "bomb.mcap", compression)
    if crashed:
        path.write_bytes(path.read_bytes()[:-20])

    assert peak_memory(partial(refuse, path)) < 8 * MEGABYTE


@pytest.mark.usefixtures("small_limits")
@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_a_ros1_chunk_that_unpacks_to_very_much_takes_no_memory(
    make_ros1_bag, tmp_path, compression
):
    path = make_ros1_bag(compression=compression, size=(1200, 1000), frames=1, truth=False)

    assert peak_memory(partial(refuse, path)) < path.stat().st_size * 4 + 8 * MEGABYTE


@pytest.mark.usefixtures("small_limits")
def test_a_message_that_unpacks_to_very_much_takes_no_memory(make_bag, monkeypatch):
    folder = make_bag(storage="sqlite3", compression="message", frames=2, truth=False)
    with closing(sqlite3.connect(storage_files(folder)[0])) as database:
        bomb = zstandard.ZstdCompressor().compress(bytes(BOMB))
        database.execute("UPDATE messages SET data = ?", (bomb,))
        database.commit()
    assert peak_memory(lambda: read(folder)) < 8 * MEGABYTE


@pytest.mark.parametrize(
    ("pack", "unpack"),
    [
        (zstandard.ZstdCompressor().compress, lambda data: unpack_zstd(data, 1000)),
        (lz4.frame.compress, lambda data: unpack_lz4(data, 1000)),
        (lz4.frame.compress, unpack_lz4),
        (bz2.compress, unpack_bz2),
    ],
)
def test_small_data_is_unpacked_whole(pack, unpack):
    data = bytes(range(250)) * 4
    assert unpack(pack(data)) == data


@pytest.mark.usefixtures("small_limits")
def test_files_are_not_unpacked_beyond_half_of_the_free_space(make_bag, monkeypatch):
    folder = make_bag(storage="sqlite3", compression="file", frames=2)
    space = namedtuple("Space", "free")
    monkeypatch.setattr(bag_limits, "disk_usage", lambda _: space(10_000))
    with pytest.raises(RecordingError, match="half of the free space"):
        check_folder(folder)


@pytest.mark.usefixtures("small_limits")
def test_metadata_that_are_no_metadata_are_not_parsed(make_bag):
    folder = make_bag()
    with (folder / "metadata.yaml").open("ab") as file:
        file.write(b"\n#" + b"x" * MEGABYTE)
    with pytest.raises(RecordingError, match=r"metadata\.yaml has more than 1 MB"):
        check_folder(folder)


def test_chunks_of_one_time_may_not_be_large_together():
    chunks = [Chunk(0, 10, bag_limits.LARGEST_OVERLAP // 2) for _ in range(3)]
    with pytest.raises(RecordingError, match="of the same time"):
        check_overlap(chunks)


def test_chunks_one_after_the_other_may_be_many():
    check_overlap(Chunk(start, start + 1, bag_limits.LARGEST_OVERLAP // 4) for start in range(99))


def test_importing_the_readers_leaves_rosbags_as_it_is():
    script = (
        "import cable_tracker.sequences.bags.open_bag, rosbags.rosbag1.reader as one;"
        "assert one.decompressors['bz2'].__module__ != 'cable_tracker.sequences.bags.bag_limits'"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_rosbags_still_unpacks_through_our_functions():
    bag_limits.limit_rosbags()
    assert bag_limits.storage_mcap.DECOMPRESSORS["zstd"] is unpack_zstd
    assert bag_limits.rosbag1_reader.decompressors["bz2"] is unpack_bz2
    assert {Reader1.__module__, Reader2.__module__} == {
        "rosbags.rosbag1.reader",
        "rosbags.rosbag2.reader",
    }
