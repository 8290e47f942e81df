"""An untrusted recording takes no memory or disk without bound, and has an end."""

from __future__ import annotations

import bz2
import sqlite3
import struct
import subprocess
import sys
import tracemalloc
from collections import namedtuple
from collections.abc import Callable
from contextlib import closing
from functools import partial
from itertools import pairwise
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
    check_database,
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


@pytest.mark.parametrize("compression", ["none", "message", "storage"])
def test_what_a_recorder_writes_is_within_the_limits(make_bag, compression):
    read(make_bag(compression=compression))


@pytest.mark.parametrize("compression", ["none", "message", "file"])
def test_a_database_of_a_recorder_is_within_the_limits(make_bag, compression):
    read(make_bag(storage="sqlite3", compression=compression))


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_a_ros1_bag_is_within_the_limits(make_ros1_bag, compression):
    read(make_ros1_bag(compression=compression))


@pytest.mark.parametrize(
    ("pack", "unpack"),
    [
        (zstandard.ZstdCompressor().compress, lambda data: unpack_zstd(data, 1000)),
        (lz4.frame.compress, lambda data: unpack_lz4(data, 1000)),
        (lz4.frame.compress, unpack_lz4),
        (bz2.compress, unpack_bz2),
    ],
)
def test_what_is_small_is_unpacked_whole(pack, unpack):
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


RECORDER = (
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT,"
    " offered_qos_profiles TEXT);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
    "INSERT INTO topics VALUES(1, '/image', 'sensor_msgs/msg/Image', 'cdr', '');"
    "INSERT INTO messages VALUES(1, 1, 1, x'00010000');"
)
ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i"


def database(path: Path, *statements: str) -> Path:
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(";".join(statements))
        connection.commit()
    return path


@pytest.mark.parametrize(
    ("statements", "words"),
    [
        (
            (
                RECORDER,
                f"CREATE VIEW message_definitions AS {ENDLESS} AS topic_type, 1 AS encoding FROM n",
            ),
            "views, triggers or virtual tables",
        ),
        (
            (RECORDER, "CREATE VIRTUAL TABLE files USING fts4(content)"),
            "views, triggers or virtual tables",
        ),
        (
            (RECORDER, "ALTER TABLE messages ADD COLUMN more AS (zeroblob(100000000))"),
            "computes columns",
        ),
        (
            (
                RECORDER.replace("id INTEGER PRIMARY KEY, name", "id INTEGER, name"),
                "INSERT INTO topics SELECT * FROM topics",
            ),
            "have the same number",
        ),
    ],
)
def test_a_database_that_holds_more_than_data_is_refused(tmp_path, statements, words):
    path = database(tmp_path / "dive.db3", *statements)
    with pytest.raises(RecordingError, match=words):
        check_database(path)
    with pytest.raises(RecordingError, match=words):
        open_source(path)


def test_a_database_is_checked_that_rosbags_unpacks(make_bag, tmp_path):
    path = make_bag(storage="sqlite3", compression="file")
    (packed,) = path.glob("*.db3.zstd")
    plain = tmp_path / "plain.db3"
    plain.write_bytes(zstandard.ZstdDecompressor().decompressobj().decompress(packed.read_bytes()))
    database(plain, "ALTER TABLE messages ADD COLUMN more AS (zeroblob(100000000))")
    packed.write_bytes(zstandard.compress(plain.read_bytes()))
    with pytest.raises(RecordingError, match="computes columns"):
        open_source(path)


def test_a_database_of_plain_tables_is_read(tmp_path):
    read(database(tmp_path / "dive.db3", RECORDER))


def looped(path: Path) -> Path:
    """Let all pages of a level of the table of messages be one page, so that rows have no end."""
    rows = "INSERT INTO messages(topic_id, timestamp, data) VALUES(1, 1, zeroblob(300))"
    database(path, "PRAGMA page_size = 512", RECORDER, *[rows] * 1000)
    with closing(sqlite3.connect(path)) as connection:
        query = "SELECT rootpage FROM sqlite_master WHERE name = 'messages'"
        (root,) = connection.execute(query).fetchone()
    data = bytearray(path.read_bytes())
    kinds = {number: data[512 * (number - 1)] for number in range(2, len(data) // 512 + 1)}
    inner = [number for number, kind in kinds.items() if kind == 5 and number != root]
    leaf = next(number for number, kind in kinds.items() if kind == 13)
    levels = [root, *inner[:8], leaf]
    for page, child in pairwise(levels):
        start = 512 * (page - 1)
        (cells,) = struct.unpack_from(">H", data, start + 3)
        # The last child stands in the header, the others at the beginning of their cells.
        struct.pack_into(">I", data, start + 8, child)
        for cell in range(cells):
            (offset,) = struct.unpack_from(">H", data, start + 12 + 2 * cell)
            struct.pack_into(">I", data, start + offset, child)
    path.write_bytes(data)
    return path


def test_a_database_whose_rows_have_no_end_is_refused(tmp_path):
    path = looped(tmp_path / "dive.db3")
    with pytest.raises(RecordingError, match="more rows than its file can hold"):
        check_database(path)


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
