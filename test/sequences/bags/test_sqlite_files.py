"""An untrusted database is data alone, and has an end; of a damaged one the beginning is read."""

from __future__ import annotations

import os
import sqlite3
import struct
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import pytest
import zstandard

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.sqlite_files import check_database, read_messages
from cable_tracker.sequences.source import open_source

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
    with open_source(database(tmp_path / "dive.db3", RECORDER), skip_bad_frames=True) as source:
        assert len(list(source.frames())) == 1


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


def test_all_messages_of_an_intact_file_are_read(make_bag):
    messages = list(read_messages(make_bag(storage="sqlite3") / "bag.db3"))
    assert len(messages) == 5 + 3 + 5
    assert [m.msgtype for m in messages if m.topic == "/camera/image"] == [
        "sensor_msgs/msg/Image"
    ] * 5


def test_messages_before_the_cut_are_read(make_bag):
    path = make_bag(storage="sqlite3", frames=20, size=(64, 48)) / "bag.db3"
    os.truncate(path, path.stat().st_size // 2)
    count = 0
    with pytest.raises(RecordingError, match="damaged"):
        for message in read_messages(path):
            count += message.topic == "/camera/image"
    assert 5 < count < 12


@pytest.mark.parametrize("content", [b"", b"SQLite format 3\0", b"x" * 5000])
def test_a_file_that_is_no_bag_is_refused(tmp_path, content):
    (tmp_path / "x.db3").write_bytes(content)
    with pytest.raises(RecordingError):
        list(read_messages(tmp_path / "x.db3"))


def test_a_name_with_special_characters(make_bag, tmp_path):
    path = tmp_path / "a b?c#d%20.db3"
    (make_bag(storage="sqlite3") / "bag.db3").rename(path)
    assert len(list(read_messages(path))) == 13
