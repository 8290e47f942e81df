from fractions import Fraction

import av
import numpy as np
import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bag import BagSource
from cable_tracker.sequences.bag_writer import BagWriter
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.messages.headers import make_header, make_time
from cable_tracker.sequences.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.video_stream import DECODERS, FFMPEG, FOXGLOVE

FACTORY = RosbagsMessages()
COUNT, KEY_EVERY = 12, 4
FIRST, STEP = 1_700_000_000_123_456_789, 40_000_001


def level(index: int) -> int:
    return 40 + 15 * index


def packets(encoder: str, **options: str) -> list[tuple[int, bytes]]:
    """Number of the picture, and bytes, in the order of coding."""
    context = av.CodecContext.create(encoder, "w")
    context.width, context.height, context.pix_fmt = 64, 48, "yuv420p"
    context.time_base, context.gop_size = Fraction(1, 25), KEY_EVERY
    context.options = options
    coded = []
    for index in range(COUNT):
        picture = np.full((48, 64, 3), level(index), np.uint8)
        frame = av.VideoFrame.from_ndarray(picture, format="bgr24").reformat(format="yuv420p")
        frame.pts = index
        coded += context.encode(frame)
    coded += context.encode(None)
    return [(int(packet.pts), bytes(packet)) for packet in coded]


H264 = {"preset": "ultrafast", "tune": "zerolatency", "x264-params": "repeat-headers=1:scenecut=0"}


def foxglove(stamp: int, data: bytes, coding: str):
    return FACTORY.make(
        FOXGLOVE, timestamp=make_time(FACTORY, stamp), frame_id="eye", format=coding,
        data=np.frombuffer(data, np.uint8),
    )  # fmt: skip


def ffmpeg(stamp: int, data: bytes, coding: str):
    return FACTORY.make(
        FFMPEG, header=make_header(FACTORY, stamp, "eye"), width=64, height=48, encoding=coding,
        data=np.frombuffer(data, np.uint8),
    )  # fmt: skip


def bag_of(path, coded, coding="h264", kind=FOXGLOVE):
    make = foxglove if kind == FOXGLOVE else ffmpeg
    with BagWriter(path) as bag:
        for number, (index, data) in enumerate(coded):
            message = make(FIRST + index * STEP, data, coding)
            bag.write("/video", kind, message, FIRST + number * STEP)
    return path


def shown(path, **options):
    """Stamp and mean grey level of each frame; None where there is no picture."""
    with BagSource(path, **options) as source:
        return [
            (
                frame.stamp,
                round(float(decode_grey(frame.image).mean())) if frame.image.data else None,
            )
            for frame in source.frames()
        ]


def is_as_coded(frames, indices):
    stamps = [stamp for stamp, _ in frames] == [FIRST + index * STEP for index in indices]
    return stamps and all(
        abs(found - level(index)) <= 6 for (_, found), index in zip(frames, indices, strict=True)
    )


@pytest.mark.parametrize("kind", [FOXGLOVE, FFMPEG])
def test_every_picture_comes_with_the_stamp_of_its_packet(tmp_path, kind):
    path = bag_of(tmp_path / "bag", packets("libx264", **H264), "h264", kind)
    assert is_as_coded(shown(path), range(COUNT))


@pytest.mark.parametrize(
    ("encoder", "coding"),
    [("libx265", "h265"), ("libvpx-vp9", "vp9"), ("libsvtav1", "av1"), ("libaom-av1", "av1")],
)
def test_other_codings_are_read(tmp_path, encoder, coding):
    if encoder not in av.codecs_available:
        pytest.skip(f"this build of FFmpeg has no encoder {encoder}")
    options = (
        {"cpu-used": "8", "lag-in-frames": "0"}
        if "lib" in encoder and "x265" not in encoder
        else {}
    )
    path = bag_of(tmp_path / "bag", packets(encoder, **options), coding)
    assert is_as_coded(shown(path), range(COUNT))


@pytest.mark.parametrize(("encoder", "coding"), [("libx264", "h264"), ("libvpx-vp9", "vp9")])
def test_a_picture_of_too_many_pixels_is_not_decoded(tmp_path, monkeypatch, encoder, coding):
    monkeypatch.setattr("cable_tracker.sequences.video_stream.MAX_PIXELS", 1000)
    path = bag_of(tmp_path / "bag", packets(encoder), coding)
    with pytest.raises(RecordingError, match="not one picture"):
        shown(path)


def test_pictures_that_are_coded_out_of_order_come_in_order(tmp_path):
    options = {"preset": "medium", "x264-params": "bframes=2:b-adapt=0:repeat-headers=1"}
    coded = packets("libx264", **options)
    assert [index for index, _ in coded] != sorted(index for index, _ in coded)
    assert is_as_coded(shown(bag_of(tmp_path / "bag", coded)), range(COUNT))


def test_a_recording_that_begins_in_the_middle_starts_at_a_key_frame(tmp_path):
    path = bag_of(tmp_path / "bag", packets("libx264", **H264)[2:])
    assert is_as_coded(shown(path), range(KEY_EVERY, COUNT))


def test_after_a_damaged_packet_it_goes_on_at_the_next_key_frame(tmp_path):
    coded = packets("libx264", **H264)
    coded[5] = (5, b"\x00\x00\x00\x01\xff" + b"\x13" * 20)
    frames = shown(bag_of(tmp_path / "bag", coded), skip_bad_frames=True)
    sound = [(stamp, found) for stamp, found in frames if found is not None]
    indices = [(stamp - FIRST) // STEP for stamp, _ in sound]
    assert 5 not in indices and set(indices) >= {0, 1, 2, 3, 4, 8, 9, 10, 11}
    assert is_as_coded(sound, indices)


def test_a_stream_without_a_key_frame_is_refused(tmp_path):
    path = bag_of(tmp_path / "bag", packets("libx264", **H264)[1:3])
    with pytest.raises(RecordingError, match="holds no key frame"):
        shown(path)


def test_an_unknown_coding_is_refused(tmp_path):
    path = bag_of(tmp_path / "bag", [(0, b"abc")], "theora")
    with pytest.raises(RecordingError, match="coding is not known"):
        shown(path)


def test_senders_may_name_encoders_instead_of_codings():
    assert DECODERS["libx264"] == DECODERS["h264"] and DECODERS["hevc"] == DECODERS["h265"]
