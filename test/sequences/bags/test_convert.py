from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences.bags import convert
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.convert import (
    ImageFormat,
    WrittenBag,
    carried_messages,
    gain_of,
    in_format,
    write_bag,
)
from cable_tracker.sequences.bags.instrument_source import InstrumentSource
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.encodings import decode_bgr, decode_grey, raw_from_array
from cable_tracker.sequences.frame import CompressedImage, Frame, RawImage
from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.source import open_source


def broken_off(frames):
    yield from frames
    raise RecordingError("old.bag: breaks off here")


def read(path) -> list[Frame]:
    with open_source(path) as source:
        return list(source.frames())


def colour_frame() -> Frame:
    picture = np.random.default_rng(1).integers(0, 256, (24, 32, 3)).astype(np.uint8)
    return Frame(0, 5, raw_from_array(picture, "bgr8"))


def test_the_format_as_is_keeps_the_frame(make_frame):
    frame = make_frame(1)
    assert in_format(frame, ImageFormat.AS_IS) is frame


def test_grey_is_what_the_tracker_sees():
    frame = colour_frame()
    grey = in_format(frame, ImageFormat.GREY)
    assert isinstance(grey.image, RawImage)
    assert grey.image.encoding == "mono8"
    difference = decode_grey(grey.image).astype(float) - decode_grey(frame.image)
    assert np.abs(difference).max() <= 0.5
    assert (grey.index, grey.stamp) == (frame.index, frame.stamp)


def test_jpeg_is_compressed_with_high_quality():
    smooth = np.add.outer(np.arange(48), np.arange(64)).astype(np.uint8)
    frame = Frame(0, 5, raw_from_array(smooth, "mono8"))
    compressed = in_format(frame, ImageFormat.JPEG)
    assert isinstance(compressed.image, CompressedImage)
    difference = decode_bgr(compressed.image).astype(int) - decode_bgr(frame.image)
    assert np.abs(difference).max() <= 6


def deep_frames(*brightest: int) -> list[Frame]:
    """Grey ramps of 16 bits up to some levels."""
    ramps = [np.linspace(0, level, 24 * 32).reshape(24, 32) for level in brightest]
    return [
        Frame(k, 5 + k, raw_from_array(ramp.astype(np.uint16), "mono16"))
        for k, ramp in enumerate(ramps)
    ]


def test_a_camera_of_12_bits_gets_one_gain_for_all_frames():
    assert gain_of(deep_frames(4095, 300)) == gain_of(deep_frames(300, *[4095] * 20)) == 8.0
    assert gain_of(deep_frames(1023)) == 32.0


@pytest.mark.parametrize(
    "frames",
    [
        deep_frames(*[4095] * 10, 65535),
        deep_frames(0),
        [],
        [Frame(0, 5, raw_from_array(np.zeros((24, 32), np.uint8), "mono8"))],
    ],
    ids=["bright later", "black", "none", "8 bits"],
)
def test_otherwise_levels_stay_as_they_are(frames):
    assert gain_of(frames) == 1.0


def test_frames_without_a_readable_picture_and_what_follows_a_damage_do_not_count():
    bad = Frame(0, 5, RawImage("mono16", 1, 1, 0, False, memoryview(b"")))
    assert gain_of(broken_off([bad, *deep_frames(*[4095] * 10)])) == 8.0


@pytest.mark.parametrize("image_format", [ImageFormat.GREY, ImageFormat.JPEG])
def test_frames_are_amplified_before_they_are_rounded_and_decoded_once(
    tmp_path, monkeypatch, image_format
):
    decoded = []
    for name in ("decode_grey", "decode_bgr_levels"):
        decode = getattr(convert, name)
        monkeypatch.setattr(
            convert, name, lambda image, decode=decode: decoded.append(1) or decode(image)
        )
    frames = deep_frames(4095, 300)
    write_bag(tmp_path / "bag", frames, image_format=image_format, level_frames=frames[:1])
    assert len(decoded) == 1 + 2
    one, other = (decode_grey(frame.image) for frame in read(tmp_path / "bag"))
    assert one.max() == pytest.approx(127, abs=3)
    assert other.max() == pytest.approx(9, abs=3)
    assert len(np.unique(one)) > 100


def test_frames_and_truths_are_read_back(tmp_path, make_frame, state):
    frames = [make_frame(k, truth=state(k) if k % 2 else None) for k in range(1, 5)]
    assert write_bag(tmp_path / "bag", frames) == WrittenBag(4, 0, None)
    again = read(tmp_path / "bag")
    assert [frame.stamp for frame in again] == [frame.stamp for frame in frames]
    assert [frame.truth for frame in again] == [frame.truth for frame in frames]
    assert [bytes(f.image.data) for f in again] == [bytes(f.image.data) for f in frames]
    assert {frame.frame_id for frame in again} == {"camera"}


def test_frames_stay_in_their_order_where_the_clock_was_set_back(tmp_path, make_frame):
    stamps = [10, 11, 12, 3, 4, 5]
    frames = [
        replace(make_frame(k), stamp=stamp * 10**9, received=(100 + k) * 10**9)
        for k, stamp in enumerate(stamps)
    ]
    write_bag(tmp_path / "bag", frames)
    assert [frame.stamp // 10**9 for frame in read(tmp_path / "bag")] == stamps


def test_the_frames_before_the_damage_are_kept(tmp_path, make_frame):
    frames = [make_frame(k) for k in range(1, 4)]
    written = write_bag(tmp_path / "bag", broken_off(frames))
    count, damage = written.count, written.damage
    assert count == 3
    assert str(damage) == "old.bag: breaks off here"
    assert len(read(tmp_path / "bag")) == 3


@pytest.mark.parametrize("frames", [[], broken_off([])], ids=["empty", "damaged"])
def test_a_bag_without_frames_is_not_written(tmp_path, frames):
    with pytest.raises(RecordingError):
        write_bag(tmp_path / "bag", frames)
    assert list(tmp_path.iterdir()) == []


def test_a_frame_that_cannot_be_decoded_leaves_no_bag(tmp_path, make_frame):
    bad = Frame(1, 6, CompressedImage("jpeg", memoryview(b"no picture")))
    with pytest.raises(FrameError, match=r"^frame 1: "):
        write_bag(tmp_path / "bag", [make_frame(0), bad], image_format=ImageFormat.GREY)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("image_format", ImageFormat)
def test_a_frame_without_an_image_is_left_out_and_counted(tmp_path, make_frame, image_format):
    empty = Frame(1, 6, CompressedImage("", memoryview(b"")))
    frames = [make_frame(0), empty, make_frame(2)]
    written = write_bag(tmp_path / "bag", frames, image_format=image_format, skip_bad_frames=True)
    assert written == WrittenBag(count=2, skipped=1, damage=None)
    assert [frame.has_image for frame in read(tmp_path / "bag")] == [True, True]


def test_a_frame_that_cannot_be_decoded_is_left_out_and_counted_on_request(tmp_path, make_frame):
    bad = Frame(1, 6, CompressedImage("jpeg", memoryview(b"no picture")))
    frames = [make_frame(0), bad, make_frame(2)]
    written = write_bag(
        tmp_path / "bag", frames, image_format=ImageFormat.GREY, skip_bad_frames=True
    )
    assert written == WrittenBag(count=2, skipped=1, damage=None)
    assert len(read(tmp_path / "bag")) == 2


def test_instruments_and_mounting_are_carried_along_in_the_order_of_their_reception(
    tmp_path: Path,
) -> None:
    factory = RosbagsMessages()
    with BagWriter(tmp_path / "dive") as bag:
        for received, topic in ((5, "/dvl/odom"), (9, "/dvl/odom")):
            odometry = factory.make("nav_msgs/msg/Odometry", header=make_header(factory, 3, "odom"))
            bag.write(topic, "nav_msgs/msg/Odometry", odometry, received)
        bag.write("/tf_static", "tf2_msgs/msg/TFMessage", factory.make("tf2_msgs/msg/TFMessage"), 7)
        bag.write("/chatter", "std_msgs/msg/String", factory.make("std_msgs/msg/String"), 8)
    source = InstrumentSource(tmp_path / "dive", open_bag(tmp_path / "dive"), "/image")
    carried = list(carried_messages(source))
    assert [(each.topic, each.bag_time) for each in carried] == [
        ("/dvl/odom", 5), ("/tf_static", 7), ("/dvl/odom", 9),
    ]  # fmt: skip
    assert stamp_of(carried[0].message.header) == 3
