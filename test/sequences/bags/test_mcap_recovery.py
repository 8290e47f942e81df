from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.mcap_recovery import is_closed, read_messages
from cable_tracker.sequences.source import open_source

FRAMES = 30
COMPRESSIONS = [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD]


@pytest.fixture
def make_mcap(tmp_path, maker, picture, first_stamp):
    """Write an mcap as a recorder does, with checksums."""

    def make(
        compression=CompressionType.NONE,
        *,
        chunks=True,
        chunk_size=20_000,
        profile="ros2",
        beside=(),
    ) -> Path:
        path = tmp_path / "dive.mcap"
        with path.open("wb") as file:
            writer = McapWriter(
                file, chunk_size=chunk_size, compression=compression, use_chunking=chunks
            )
            writer.start(profile=profile, library="test")
            for kind, encoding in beside:
                other = writer.register_schema("Log", kind, b'\n{"\xff')
                log = writer.register_channel(f"/{encoding}", encoding, other)
                writer.add_message(log, first_stamp, b"{}", first_stamp)
            schema = writer.register_schema("sensor_msgs/msg/Image", "ros2msg", b"")
            channel = writer.register_channel("/image", "cdr", schema)
            for index in range(FRAMES):
                stamp = first_stamp + index * 40_000_000
                data = maker.serialise(maker.image(stamp, picture(index, (64, 48))))
                writer.add_message(channel, stamp, data, stamp)
            writer.finish()
        return path

    return make


def cut(path: Path, share: float) -> Path:
    os.truncate(path, int(share * path.stat().st_size))
    return path


def frames_until_damage(path: Path) -> int:
    count = 0
    with open_source(path) as source, pytest.raises(RecordingError, match="damaged after"):
        for _ in source.frames():
            count += 1
    return count


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("chunks", [True, False])
def test_an_intact_file_is_read_whole(make_mcap, compression, chunks):
    path = make_mcap(compression, chunks=chunks)
    assert is_closed(path)
    assert len(list(read_messages(path))) == FRAMES


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("share", [0.3, 0.5, 0.75, 0.9])
def test_a_crashed_recording_ends_normally_with_a_note(make_mcap, compression, share):
    path = cut(make_mcap(compression), share)
    assert not is_closed(path)
    with open_source(path) as source:
        frames = list(source.frames())
    # Noise does not compress: of the last chunk of seven frames nothing may come out.
    assert share * FRAMES - 8 < len(frames) <= share * FRAMES
    assert source.frame_count == len(frames)
    assert f"read as far as it goes ({len(frames)} frames)" in source.note


@pytest.mark.parametrize("share", [0.1, 0.37, 0.5, 0.75, 0.9])
@pytest.mark.parametrize("chunks", [True, False])
def test_without_compression_no_whole_frame_is_lost(make_mcap, chunks, share):
    path = make_mcap(chunks=chunks, chunk_size=1_000_000)
    messages = FRAMES * (64 * 48 + 150)
    frames = len(list(read_messages(cut(path, share))))
    assert frames >= int(share * messages / (64 * 48 + 150)) - 1


def test_only_the_footer_is_missing(make_mcap):
    path = make_mcap()
    os.truncate(path, path.stat().st_size - 8)
    assert len(list(open_source(path).frames())) == FRAMES


def test_a_tail_of_zeros_is_no_damage(make_mcap):
    path = cut(make_mcap(chunks=False), 0.5)
    intact = len(list(read_messages(path)))
    with path.open("r+b") as file:
        file.truncate(path.stat().st_size - 1000)
    before = len(list(read_messages(path)))
    assert 0 <= intact - before <= 1


def test_zeros_after_the_last_record_are_no_damage(make_mcap):
    path = make_mcap()
    content = path.read_bytes()
    data_end = content.rindex(b"\x0f\x04\0\0\0\0\0\0\0")
    path.write_bytes(content[:data_end] + bytes(4096))
    assert len(list(read_messages(path))) == FRAMES


def test_garbage_inside_is_damage_after_the_frames_before(make_mcap):
    path = cut(make_mcap(chunks=False), 0.9)
    data = bytearray(path.read_bytes())
    data[len(data) // 2 :] = np.random.default_rng(3).bytes(len(data) - len(data) // 2)
    path.write_bytes(data)
    assert 10 <= frames_until_damage(path) <= 14


def test_a_wrong_checksum_is_damage(make_mcap):
    path = cut(make_mcap(CompressionType.NONE), 0.9)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)
    assert 6 <= frames_until_damage(path) <= 14


def test_not_one_frame_is_an_error(make_mcap):
    path = make_mcap()
    os.truncate(path, 300)
    with pytest.raises(RecordingError, match=r"dive\.mcap: .*before the first message"):
        open_source(path)


def test_a_folder_of_a_crashed_recorder(make_bag):
    path = make_bag(frames=20, size=(64, 48))
    (path / "metadata.yaml").unlink()
    cut(path / "bag.mcap", 0.5)
    source = open_source(path)
    frames = list(source.frames())
    assert 8 <= len(frames) <= 10
    assert source.has_truth
    assert frames[2].truth is not None


def test_the_last_file_of_a_split_recording_may_be_empty(make_bag):
    path = make_bag(frames=5)
    (path / "metadata.yaml").unlink()
    (path / "bag_1.mcap").touch()
    assert len(list(open_source(path).frames())) == 5


def test_a_split_recording_is_read_up_to_the_cut_of_its_last_file(make_bag):
    path = make_bag(frames=20, size=(64, 48))
    (path / "metadata.yaml").unlink()
    whole = (path / "bag.mcap").read_bytes()
    (path / "bag.mcap").rename(path / "bag_0.mcap")
    (path / "bag_1.mcap").write_bytes(whole[: len(whole) // 2])
    assert 28 <= len(list(open_source(path).frames())) <= 30


@pytest.mark.parametrize("beside", [("jsonschema", "json"), ("protobuf", "protobuf")])
@pytest.mark.parametrize("share", [1.0, 0.9])
def test_ros2_messages_are_read_beside_others(make_mcap, beside, share):
    path = cut(make_mcap(beside=[beside]), share)
    with open_source(path) as source:
        count = len(list(source.frames()))
        assert source.storage.topics.keys() == {"/image"}
    assert count == FRAMES if share == 1.0 else 0 < count < FRAMES
    assert source.note


def test_an_mcap_that_does_not_say_what_it_holds_is_not_damaged(make_mcap):
    with open_source(make_mcap(profile="")) as source:
        assert len(list(source.frames())) == FRAMES
        assert "does not say that it is" in source.note


def test_damage_beside_other_messages_is_reported(make_mcap):
    path = make_mcap(beside=[("jsonschema", "json")])
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 200] = b"\x55" * 200
    path.write_bytes(content)
    assert 0 < frames_until_damage(path) < FRAMES


def test_an_mcap_of_ros1_is_refused_in_words(make_mcap):
    path = make_mcap(profile="ros1")
    with pytest.raises(RecordingError, match=r"holds ROS 1 messages, .* convert it"):
        open_source(path)
