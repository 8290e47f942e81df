from __future__ import annotations

import os

import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.sqlite_recovery import read_messages


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
def test_what_is_no_bag_is_refused(tmp_path, content):
    (tmp_path / "x.db3").write_bytes(content)
    with pytest.raises(RecordingError):
        list(read_messages(tmp_path / "x.db3"))


def test_a_name_with_special_characters(make_bag, tmp_path):
    path = tmp_path / "a b?c#d%20.db3"
    (make_bag(storage="sqlite3") / "bag.db3").rename(path)
    assert len(list(read_messages(path))) == 13
