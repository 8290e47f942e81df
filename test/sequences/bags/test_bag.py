from __future__ import annotations

import os
import re
import shutil
import sqlite3
from contextlib import closing

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer

from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences.bags.bag import BagSource, read_bag_truth
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.source import open_source
from cable_tracker.sequences.source_base import ChosenRecording

STORAGES = [
    ("mcap", "none"), ("mcap", "file"), ("mcap", "message"), ("mcap", "storage"),
    ("sqlite3", "none"), ("sqlite3", "file"), ("sqlite3", "message"),
]  # fmt: skip


def read(path, **options):
    with open_source(path, **options) as source:
        return list(source.frames())


def read_until_damage(path, **options):
    """Return the frames before the damage, and the message."""
    frames = []
    with open_source(path, **options) as source, pytest.raises(RecordingError) as caught:
        for frame in source.frames():
            frames.append(frame)
    return frames, str(caught.value)


def assert_complete(frames, picture, state, first_stamp):
    assert [frame.index for frame in frames] == [0, 1, 2, 3, 4]
    for index, frame in enumerate(frames):
        assert frame.stamp == first_stamp + index * 40_000_000
        assert frame.frame_id == "eye"
        assert frame.truth == (state(index) if index % 2 == 0 else None)
        np.testing.assert_array_equal(decode_grey(frame.image), picture(index))


@pytest.mark.parametrize(("storage", "compression"), STORAGES)
@pytest.mark.parametrize("compressed_images", [False, True])
def test_ros2_bags_of_every_kind(
    make_bag, picture, state, first_stamp, *, storage, compression, compressed_images
):
    path = make_bag(storage=storage, compression=compression, compressed_images=compressed_images)
    assert_complete(read(path), picture, state, first_stamp)


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
@pytest.mark.parametrize("compressed_images", [False, True])
def test_ros1_bags_of_every_kind(
    make_ros1_bag, picture, state, first_stamp, *, compression, compressed_images
):
    path = make_ros1_bag(compression=compression, compressed_images=compressed_images)
    assert_complete(read(path), picture, state, first_stamp)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_single_storage_file_is_enough(make_bag, picture, state, first_stamp, storage):
    suffix = {"mcap": "mcap", "sqlite3": "db3"}[storage]
    file = make_bag(storage=storage) / f"bag.{suffix}"
    assert_complete(read(file), picture, state, first_stamp)


def test_a_single_file_of_a_bag_with_compressed_messages(make_bag, picture, state, first_stamp):
    file = make_bag(storage="sqlite3", compression="message") / "bag.db3"
    assert_complete(read(file), picture, state, first_stamp)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_folder_without_metadata_is_enough(make_bag, picture, state, first_stamp, storage):
    path = make_bag(storage=storage)
    (path / "metadata.yaml").unlink()
    assert_complete(read(path), picture, state, first_stamp)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_files_of_a_split_bag_are_read_in_order(make_bag, storage):
    suffix = {"mcap": "mcap", "sqlite3": "db3"}[storage]
    path = make_bag("split", storage=storage)
    other = make_bag("other", storage=storage)
    (path / f"split.{suffix}").rename(path / f"split_9.{suffix}")
    shutil.copy(other / f"other.{suffix}", path / f"split_10.{suffix}")
    (path / "metadata.yaml").unlink()
    source = open_source(path)
    assert source.frame_count == len(list(source.frames())) == 10
    assert "2 files" in source.note


def test_a_ros2_bag_may_be_called_like_a_ros1_bag(make_bag, picture, state, first_stamp):
    assert_complete(read(make_bag("dive.bag")), picture, state, first_stamp)


@pytest.mark.parametrize("compressed_images", [False, True])
@pytest.mark.parametrize("from_ros1", [False, True])
def test_pictures_of_another_type_under_the_same_name_are_reported(
    make_bag, make_ros1_bag, *, compressed_images, from_ros1
):
    make = make_ros1_bag if from_ros1 else make_bag
    path = make(compressed_images=compressed_images, both_types=True)
    own, other = ("CompressedImage", "Image")[:: 1 if compressed_images else -1]
    reason = (
        f"it is a {other}, and /camera/image is read as {own}: two publishers have sent different"
        " types under that name; record each under a name of its own"
    )
    with pytest.raises(RecordingError, match=re.escape(f"frame 1 cannot be decoded ({reason});")):
        read(path)
    frames = read(path, skip_bad_frames=True)
    assert [frame.image.missing for frame in frames] == ["", reason] * 5


def test_a_bag_describes_its_content(make_bag):
    source = open_source(make_bag(frames=20))
    assert source.frame_count == 20
    assert source.has_truth
    assert not source.compressed
    assert source.note == ""
    assert open_source(make_bag("c", compressed_images=True)).compressed
    assert not open_source(make_bag("t", truth=False)).has_truth


def test_frames_hold_the_pixels_as_recorded(make_bag):
    assert isinstance(read(make_bag())[0].image, RawImage)
    assert isinstance(read(make_bag("c", compressed_images=True))[0].image, CompressedImage)


def test_every_pass_over_the_frames_begins_at_the_first(make_bag):
    with open_source(make_bag()) as source:
        first = source.frames()
        next(first)
        assert [frame.index for frame in source.frames()] == [0, 1, 2, 3, 4]
        assert next(first).index == 1


def test_without_a_header_stamp_the_receive_time_counts(make_bag, state, first_stamp):
    frames = read(make_bag(stamped=False))
    assert [frame.stamp for frame in frames[:2]] == [first_stamp + 1000, first_stamp + 40_001_000]
    assert frames[2].truth == state(2)


@pytest.mark.parametrize(("storage", "compression"), STORAGES)
@pytest.mark.parametrize("compressed_images", [False, True])
def test_frames_are_chosen_by_their_stamps_however_the_bag_is_compressed(
    make_bag, first_stamp, *, storage, compression, compressed_images
):
    path = make_bag(storage=storage, compression=compression, compressed_images=compressed_images)
    asked = []
    with open_source(path) as source:
        chosen = source.chosen_frames(lambda stamp: asked.append(stamp) or len(asked) in {2, 4})
        assert [frame.index for frame in chosen] == [1, 3]
    assert asked == [first_stamp + index * 40_000_000 for index in range(5)]


def test_a_packed_picture_whose_beginning_is_damaged_is_asked_about_by_the_clock_of_the_others(
    make_bag, first_stamp
):
    path = make_bag(storage="sqlite3", compression="message")
    with closing(sqlite3.connect(path / "bag.db3")) as database, database:
        damaged = b"\x28\xb5\x2f\xfd" + bytes(20)
        database.execute(
            "UPDATE messages SET data = ? WHERE timestamp = ? AND topic_id ="
            " (SELECT id FROM topics WHERE name = '/camera/image')",
            (damaged, first_stamp + 1000),
        )
    asked = []
    with open_source(path, skip_bad_frames=True) as source:
        assert not list(source.chosen_frames(lambda stamp: bool(asked.append(stamp))))
    assert asked[:2] == [first_stamp, first_stamp + 40_000_000]


@pytest.mark.parametrize("name", ["/left/image", "left/image", "left/image/"])
def test_the_topic_may_be_named_with_or_without_slash(make_bag, name):
    path = make_bag(topics=("/left/image", "/right/image"))
    assert len(read(path, topic=name)) == 5


def test_several_image_topics_need_a_choice(make_bag):
    with pytest.raises(
        RecordingError, match=r"--topic \(node: topic\): /left/image .*, /right/image"
    ):
        open_source(make_bag(topics=("/left/image", "/right/image")))


def test_a_bag_without_images_is_refused_with_its_topics(make_bag):
    with pytest.raises(RecordingError, match=r"holds no images .*/chatter \(std_msgs/msg/String"):
        open_source(make_bag(topics=()))


@pytest.mark.parametrize("topic", ["/nothing", "/chatter"])
def test_a_wrong_topic_is_refused(make_bag, topic):
    with pytest.raises(RecordingError, match=f"no image topic {topic}; the bag holds /camera"):
        open_source(make_bag(), topic=topic)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_an_empty_bag_is_refused(tmp_path, storage):
    with Writer(tmp_path / "b", version=9, storage_plugin=StoragePlugin[storage.upper()]):
        pass
    with pytest.raises(RecordingError, match="no topics"):
        open_source(tmp_path / "b")


@pytest.mark.parametrize("compressed_images", [False, True])
@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_bad_frame_stops_after_the_frames_before_it(make_bag, storage, compressed_images):
    path = make_bag(storage=storage, compressed_images=compressed_images, bad_frame=3)
    frames, message = read_until_damage(path)
    assert [frame.index for frame in frames] == [0, 1, 2]
    assert str(path) in message
    assert "frame 3 cannot be decoded" in message
    assert "--skip-bad-frames (node: skip_bad_frames)" in message
    assert ("step 3" in message) or ("truncated" in message)
    assert "\n" not in message


@pytest.mark.parametrize("compressed_images", [False, True])
def test_a_bad_frame_can_be_handed_out(make_bag, compressed_images):
    path = make_bag(compressed_images=compressed_images, bad_frame=3)
    frames = read(path, skip_bad_frames=True)
    assert [frame.index for frame in frames] == [0, 1, 2, 3, 4]
    with pytest.raises(FrameError):
        decode_grey(frames[3].image)
    decode_grey(frames[4].image)


@pytest.mark.parametrize("skip", [False, True])
def test_a_message_that_is_rubbish_is_a_bad_frame(tmp_path, maker, picture, first_stamp, skip):
    with Writer(tmp_path / "b", version=9) as writer:
        kind = "sensor_msgs/msg/Image"
        connection = writer.add_connection("image", kind, typestore=maker.store)
        good = maker.serialise(maker.image(first_stamp, picture(0)))
        for index, data in enumerate((good, good[:30], good)):
            writer.write(connection, first_stamp + index, data)
    if skip:
        frames = read(tmp_path / "b", skip_bad_frames=True)
        with pytest.raises(FrameError):
            decode_grey(frames[1].image)
        assert len(frames) == 3
        # Its header is whole, and says when it was taken.
        assert frames[1].stamp == first_stamp
    else:
        frames, message = read_until_damage(tmp_path / "b")
        assert len(frames) == 1
        assert "frame 1 cannot be decoded (damaged message" in message


@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize("left", [0, 10, 60], ids=["nothing", "half a header", "its header"])
@pytest.mark.parametrize("cut_frame", [0, 2])
def test_a_frame_that_cannot_be_unpacked_keeps_its_place_and_its_truth(
    make_bag, make_ros1_bag, state, first_stamp, ros, left, cut_frame
):
    make = make_ros1_bag if ros == 1 else make_bag
    path = make(cut_frame=cut_frame, left=left, first_stamp=5_000_000_000)
    frames = read(path, skip_bad_frames=True)
    assert [frame.has_image for frame in frames] == [index != cut_frame for index in range(5)]
    steps = [index * 40_000_000 for index in range(5)]
    assert [frame.stamp for frame in frames] == [5_000_000_000 + step for step in steps]
    assert [frame.received for frame in frames] == [first_stamp + 1000 + step for step in steps]
    assert frames[cut_frame].truth == state(cut_frame)
    assert frames[cut_frame].frame_id == ("eye" if left == 60 else "camera")


@pytest.mark.parametrize("is_beyond", [False, True], ids=["without", "beyond what can be sent"])
def test_frames_without_a_stamp_are_as_far_ahead_of_reception_as_the_one_before(
    tmp_path, maker, picture, first_stamp, is_beyond
):
    behind = first_stamp - 10**15
    stamps = [0, behind + 40_000_000, 0, behind + 120_000_000]
    with Writer(tmp_path / "b", version=9) as writer:
        kind = "sensor_msgs/msg/Image"
        connection = writer.add_connection("image", kind, typestore=maker.store)
        for index, stamp in enumerate(stamps):
            message = maker.image(stamp, picture(0))
            if is_beyond and not stamp:
                message.header.stamp.sec, message.header.stamp.nanosec = 2**31 - 1, 3 * 10**9
            data = maker.serialise(message)
            writer.write(connection, first_stamp + index * 40_000_000, data)
    found = [frame.stamp - behind for frame in read(tmp_path / "b")]
    assert found == [0, 40_000_000, 80_000_000, 120_000_000]


def test_the_stamp_of_an_unreadable_header_is_the_receive_time(make_bag, first_stamp):
    path = make_bag(frames=1, cut_frame=0, left=3)
    assert [frame.stamp for frame in read(path, skip_bad_frames=True)] == [first_stamp + 1000]


@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_frames_before_the_cut_of_a_db3_are_delivered(make_bag, share):
    path = make_bag(frames=30, storage="sqlite3", size=(160, 120))
    file = path / "bag.db3"
    os.truncate(file, int(share * file.stat().st_size))
    frames, message = read_until_damage(path)
    assert abs(len(frames) - share * 30) < 3
    assert f"{path}: damaged after {len(frames)} frames" in message


@pytest.mark.parametrize("share", [0.5, 0.7, 0.95])
@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_frames_before_the_cut_of_a_ros1_bag_are_delivered(make_ros1_bag, share, compression):
    # As much of it is in a chunk as of frames of 320x240 in one of a recorder.
    path = make_ros1_bag(frames=30, size=(80, 60), compression=compression, chunk=1 << 16)
    os.truncate(path, int(share * path.stat().st_size))
    frames, message = read_until_damage(path)
    # Of a compressed chunk that was cut off not everything can be unpacked.
    assert share * 30 - 14 < len(frames) < share * 30 + 2
    assert f"{path}: damaged after {len(frames)} frames" in message


def test_frames_before_garbage_in_a_closed_mcap_are_delivered(make_bag):
    path = make_bag(frames=20, size=(64, 48))
    file = path / "bag.mcap"
    data = bytearray(file.read_bytes())
    middle = data.index(b"eye", len(data) // 2)
    data[middle - 80 : middle] = np.random.default_rng(5).bytes(80)
    file.write_bytes(data)
    frames, message = read_until_damage(path)
    assert 7 <= len(frames) <= 12
    assert "\n" not in message


def test_after_damage_in_a_late_chunk_no_frame_comes_twice(make_bag):
    path = make_bag(frames=30, size=(320, 240))
    file = path / "bag.mcap"
    data = bytearray(file.read_bytes())
    # A message record is a 5, its length, 22 bytes, and the message: 16 bytes and the frame_id.
    record = data.index(b"eye", int(0.7 * len(data))) - 16 - 22 - 9
    assert data[record] == 5
    data[record + 1 : record + 9] = b"\xff" * 4 + bytes(4)
    file.write_bytes(data)
    frames, _ = read_until_damage(path)
    assert 20 <= len(frames) <= 22
    stamps = [frame.stamp for frame in frames]
    assert stamps == sorted(set(stamps))


def test_only_joint_states_are_ground_truth(tmp_path, maker, picture, first_stamp):
    with Writer(tmp_path / "b", version=9) as writer:
        for topic, message in (
            ("/image", maker.image(first_stamp, picture(0))),
            ("/ground_truth", maker.text("left of the rock")),
        ):
            kind = message.__msgtype__
            connection = writer.add_connection(topic, kind, typestore=maker.store)
            writer.write(connection, first_stamp, maker.serialise(message))
    source = open_source(tmp_path / "b")
    assert not source.has_truth
    assert len(list(source.frames())) == 1


@pytest.fixture(params=["rubbish", "other joints"])
def half_labelled(request, tmp_path, maker, picture, state, first_stamp):
    """Bag of two pictures, of which the second has a label that cannot be read."""
    other = maker.truth(first_stamp, state(1))
    other.name = ["shoulder", "elbow", "wrist", "hand"]
    unreadable = b"\0\1\0\0\1" if request.param == "rubbish" else maker.serialise(other)
    path = tmp_path / "half_labelled"
    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        image, truth = (
            writer.add_connection(topic, f"sensor_msgs/msg/{kind}", typestore=maker.store)
            for topic, kind in (("/image", "Image"), ("/ground_truth", "JointState"))
        )
        for index, data in enumerate(
            (maker.serialise(maker.truth(first_stamp, state(0))), unreadable)
        ):
            stamp = first_stamp + index
            writer.write(image, stamp, maker.serialise(maker.image(stamp, picture(index))))
            writer.write(truth, stamp, data)
    return path


def test_an_unreadable_label_is_left_out_with_a_note(half_labelled, state):
    with open_source(half_labelled) as source:
        assert "/ground_truth: 1 of its messages cannot be read and are left out" in source.note
        assert [frame.truth for frame in source.frames()] == [state(0), None]
    with open_source(half_labelled, with_truth=False) as source:
        assert not source.note


def test_labels_that_cannot_be_read_are_refused(half_labelled):
    with pytest.raises(RecordingError, match="ground truth on /ground_truth cannot be read"):
        read_bag_truth(half_labelled)


@pytest.mark.parametrize(
    "text", ["", "{", "rosbag2_bagfile_information: 3", "- 1\n- 2", "\0\1", "a: &a [*a"]
)
def test_corrupt_metadata_is_an_error_after_what_can_be_read(make_bag, text):
    path = make_bag()
    (path / "metadata.yaml").write_text(text)
    frames, message = read_until_damage(path)
    assert len(frames) == 5
    assert str(path) in message


def test_a_topic_without_a_name_in_the_metadata_is_found_out_from_the_messages(make_bag):
    path = make_bag(truth=False)
    metadata = path / "metadata.yaml"
    without_others = re.sub(
        r"(Image\n(?: {6,}.*\n)+) {2}-.*(?= {2}version)",
        r"\1",
        metadata.read_text(),
        flags=re.DOTALL,
    )
    metadata.write_text(without_others.replace("name: /camera/image", "name:"))
    frames, message = read_until_damage(path)
    assert len(frames) == 5
    assert "a topic whose name is no text" in message


@pytest.mark.parametrize("name", ["x.mcap", "x.db3", "x.bag"])
@pytest.mark.parametrize("length", [0, 1, 100, 100_000])
def test_garbage_is_refused(tmp_path, name, length):
    path = tmp_path / name
    path.write_bytes(np.random.default_rng(length).bytes(length))
    with pytest.raises(RecordingError, match=r"x\.\w+: not one message can be read") as caught:
        BagSource(ChosenRecording(path))
    assert "\n" not in str(caught.value)


def test_messages_that_a_recorder_left_unmerged_are_mentioned(make_bag):
    path = make_bag(storage="sqlite3")
    (path / "bag.db3-wal").write_bytes(b"x")
    assert "bag.db3-wal holds messages" in open_source(path).note


@pytest.mark.parametrize("tail", [0, 1, 8])
def test_bytes_that_a_serialiser_leaves_at_the_end_do_no_harm(tmp_path, maker, picture, tail):
    kind = "sensor_msgs/msg/Image"
    data = maker.serialise(maker.image(7, picture(0))) + b"\x99" * tail
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("image", kind, typestore=maker.store)
        writer.write(connection, 7, data)
    (frame,) = read(tmp_path / "bag")
    assert np.array_equal(decode_grey(frame.image), picture(0))
