from __future__ import annotations

import os

import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.ros1_recovery import read_messages


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_all_messages_of_an_intact_file_are_read(make_ros1_bag, first_stamp, compression):
    messages = list(read_messages(make_ros1_bag(compression=compression)))
    assert len(messages) == 5 + 3 + 5
    assert messages[0].msgtype == "sensor_msgs/msg/Image"
    assert messages[0].time == first_stamp + 1000


def test_messages_before_the_cut_are_read(make_ros1_bag):
    path = make_ros1_bag(frames=20, size=(64, 48))
    os.truncate(path, path.stat().st_size // 2)
    count = 0
    with pytest.raises(RecordingError, match="ends inside"):
        for message in read_messages(path):
            count += message.topic == "/camera/image"
    assert 7 <= count <= 10


def test_a_cut_at_any_byte_of_a_chunk_is_noticed(make_ros1_bag):
    path = make_ros1_bag(frames=4, size=(8, 6))
    content = path.read_bytes()
    middle = content.index(b"hello") + 5
    for cut in range(middle, middle + 400):
        path.write_bytes(content[:cut])
        with pytest.raises(RecordingError):
            list(read_messages(path))


@pytest.mark.parametrize("content", [b"", b"#ROSBAG V1.2\n", b"x" * 5000])
def test_a_file_that_is_no_bag_is_refused(tmp_path, content):
    (tmp_path / "x.bag").write_bytes(content)
    with pytest.raises(RecordingError, match="does not begin like"):
        list(read_messages(tmp_path / "x.bag"))
