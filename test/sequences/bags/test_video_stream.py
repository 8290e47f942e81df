import os
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from fractions import Fraction

import av
import numpy as np
import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_storage import FFMPEG, FOXGLOVE
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.bags.video_stream import DECODERS
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.messages.headers import make_header, make_time
from cable_tracker.sequences.source import open_source

FACTORY = RosbagsMessages()
COUNT, KEY_EVERY = 12, 4
FIRST, STEP = 1_700_000_000_123_456_789, 40_000_001


Picture = Callable[[int], np.ndarray]


def level(index: int) -> int:
    return 40 + 15 * index


def plain(index: int) -> np.ndarray:
    return np.full((48, 64, 3), level(index), np.uint8)


def moving(index: int) -> np.ndarray:
    """Return a picture of which most is that of the one before, moved, with some noise."""
    bottom = np.random.default_rng(0).integers(40, 215, (32, 64), np.uint8)
    seen = bottom.repeat(4, 0).repeat(4, 1)[:, 3 * index : 3 * index + 160, None]
    noise = np.random.default_rng(index).integers(0, 30, (128, 160, 1), np.uint8)
    return np.repeat(seen + noise, 3, axis=2)


@contextmanager
def ordinary_schedule() -> Iterator[None]:
    """Give this thread its schedule back.

    For root, SVT-AV1 makes it a real-time one of the highest priority. Processes that it starts
    later, a browser for instance, would have that as well, and starve all others.
    """
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        yield
    finally:
        os.sched_setscheduler(0, policy, parameters)


@ordinary_schedule()
def packets(
    encoder: str, count: int = COUNT, picture: Picture = plain, **options: str
) -> list[tuple[int, bytes]]:
    """Number of the picture, and bytes, in the order of coding."""
    context = av.CodecContext.create(encoder, "w")
    context.height, context.width = picture(0).shape[:2]
    context.pix_fmt = "yuv420p"
    context.time_base, context.gop_size = Fraction(1, 25), KEY_EVERY
    context.options = options
    coded = []
    for index in range(count):
        frame = av.VideoFrame.from_ndarray(picture(index), format="bgr24")
        frame = frame.reformat(format="yuv420p")
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


def bag_of(path, coded, coding="h264", kind=FOXGLOVE, first_stamp=FIRST):
    make = foxglove if kind == FOXGLOVE else ffmpeg
    with BagWriter(path) as bag:
        for number, (index, data) in enumerate(coded):
            message = make(first_stamp + index * STEP, data, coding)
            bag.write("/video", kind, message, FIRST + number * STEP)
    return path


def shown(path, **options):
    """Stamp and mean grey level of each frame; None where there is no picture."""
    with open_source(path, **options) as source:
        return [
            (
                frame.stamp,
                round(float(decode_grey(frame.image).mean())) if frame.image.data else None,
            )
            for frame in source.frames()
        ]


def pictures(path, **options):
    """Stamp and grey levels of each frame that has a picture."""
    with open_source(path, **options) as source:
        return [
            (frame.stamp, decode_grey(frame.image)) for frame in source.frames() if frame.image.data
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


OUT_OF_ORDER = {"preset": "medium", "x264-params": "bframes=2:b-adapt=0:repeat-headers=1"}


@pytest.mark.parametrize("kind", [FOXGLOVE, FFMPEG])
@pytest.mark.parametrize("options", [H264, OUT_OF_ORDER])
def test_a_picture_was_received_when_its_packet_was_whatever_the_clock_of_the_camera(
    tmp_path, kind, options
):
    coded = packets("libx264", **options)
    path = bag_of(tmp_path / "bag", coded, "h264", kind, first_stamp=100_000_000_000)
    received = {index: FIRST + number * STEP for number, (index, _) in enumerate(coded)}
    with open_source(path) as source:
        frames = list(source.frames())
    assert [frame.stamp for frame in frames] == [
        100_000_000_000 + index * STEP for index in range(COUNT)
    ]
    assert [frame.received for frame in frames] == [received[index] for index in range(COUNT)]


@pytest.mark.parametrize("encoder", ["libx264", "libx265", "libvpx-vp9", "libsvtav1", "libaom-av1"])
def test_no_encoder_leaves_a_real_time_schedule_behind(encoder):
    if encoder in av.codecs_available:
        packets(encoder)
    assert os.sched_getscheduler(0) == os.SCHED_OTHER


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
    monkeypatch.setattr("cable_tracker.sequences.bags.video_stream.MAX_PIXELS", 1000)
    path = bag_of(tmp_path / "bag", packets(encoder), coding)
    with pytest.raises(RecordingError, match="not one picture"):
        shown(path)


def test_pictures_that_are_coded_out_of_order_come_in_order(tmp_path):
    coded = packets("libx264", **OUT_OF_ORDER)
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


@pytest.mark.parametrize("kind", [FOXGLOVE, FFMPEG])
def test_a_packet_that_cannot_be_unpacked_has_the_time_of_its_header(tmp_path, kind):
    clock = 100_000_000_000
    source = bag_of(tmp_path / "bag", packets("libx264", **H264), "h264", kind, first_stamp=clock)
    with closing(open_bag(source)) as whole, BagWriter(tmp_path / "torn") as bag:
        for number, each in enumerate(whole.messages(list(whole.topics))):
            data = each.data[:40] if number == 5 else each.data
            bag.write_serialised(each.topic, each.msgtype, data, each.time)
    with open_source(tmp_path / "torn", skip_bad_frames=True) as torn:
        frames = {frame.stamp: frame for frame in torn.frames()}
    unreadable = frames[clock + 5 * STEP]
    assert (unreadable.has_image, unreadable.frame_id) == (False, "eye")
    assert unreadable.received == FIRST + 5 * STEP


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


NOISE = {"cpu-used": "8", "lag-in-frames": "0"}
CODINGS = [
    ("libx264", "h264", H264),
    (
        "libx264",
        "h264",
        {"preset": "medium", "x264-params": "bframes=2:b-adapt=0:repeat-headers=1:scenecut=0"},
    ),
    (
        "libx265",
        "h265",
        {"tune": "zerolatency", "x265-params": "repeat-headers=1:scenecut=0:log-level=none:crf=12"},
    ),
    ("libvpx-vp9", "vp9", NOISE),
    ("libsvtav1", "av1", {"preset": "12"}),
    ("libaom-av1", "av1", NOISE),
]
HURT = 2 * KEY_EVERY + 2
"""The packet that something happens to, in the order of coding."""


def without(coded):
    return coded[:HURT] + coded[HURT + 1 :]


def cut_off(coded):
    (index, data), rest = coded[HURT], coded[HURT + 1 :]
    return [*coded[:HURT], (index, data[: len(data) // 2]), *rest]


def emptied(coded):
    return [*coded[:HURT], (coded[HURT][0], b""), *coded[HURT + 1 :]]


def scrambled(coded):
    index, data = coded[HURT]
    other = np.random.default_rng(0).bytes(len(data))
    return [*coded[:HURT], (index, other), *coded[HURT + 1 :]]


def without_a_key_frame(coded):
    place = [index for index, _ in coded].index(2 * KEY_EVERY)
    return coded[:place] + coded[place + 1 :]


@pytest.fixture(scope="module", params=CODINGS, ids=lambda each: each[1])
def sound_video(request, tmp_path_factory):
    """A video that nothing has happened to: its coding, its packets, and its pictures by stamp."""
    encoder, coding, options = request.param
    if encoder not in av.codecs_available:
        pytest.skip(f"this build of FFmpeg has no encoder {encoder}")
    coded = packets(encoder, count=5 * KEY_EVERY, picture=moving, **options)
    path = bag_of(tmp_path_factory.mktemp("sound") / "bag", coded, coding)
    return coding, coded, dict(pictures(path))


@pytest.mark.parametrize("hurt", [without, cut_off, emptied, scrambled, without_a_key_frame])
def test_concealed_pictures_are_dropped_and_the_others_unchanged(tmp_path, sound_video, hurt):
    coding, coded, sound = sound_video
    if coding == "h265" and hurt is cut_off:
        pytest.skip("its decoder does not see that a packet ends early")
    found = dict(pictures(bag_of(tmp_path / "hurt", hurt(coded), coding), skip_bad_frames=True))
    assert all((found[stamp] == sound[stamp]).all() for stamp in found)
    kept = {(stamp - FIRST) // STEP for stamp in found}
    # Only what lies between the hurt packet and the key frame after it is gone.
    assert {*range(2 * KEY_EVERY - 2), *range(3 * KEY_EVERY, 5 * KEY_EVERY)} <= kept


H265 = {
    "x265-params": "log-level=none:keyint=8:min-keyint=8:scenecut=0:repeat-headers=1:bframes=3"
    ":pools=1:frame-threads=1"
}


def slow(index: int) -> np.ndarray:
    return np.full((48, 64, 3), 40 + 5 * index, np.uint8)


def test_a_stream_that_begins_in_the_middle_holds_nothing_from_before(tmp_path):
    coded = packets("libx265", 32, slow, **H265)
    frames = shown(bag_of(tmp_path / "bag", coded[5:], coding="h265"))
    assert frames and all(found is not None for _, found in frames)
    assert [stamp for stamp, _ in frames] == sorted(stamp for stamp, _ in frames)


def test_packets_without_a_picture_come_before_the_next_key_frame(tmp_path):
    coded = packets("libx265", 40, slow, **H265)
    del coded[10]
    stamps = [
        stamp for stamp, _ in shown(bag_of(tmp_path / "bag", coded, "h265"), skip_bad_frames=True)
    ]
    beyond = FIRST + 24 * STEP
    late = stamps[stamps.index(beyond) :]
    assert late == sorted(late) and late[-1] == FIRST + 39 * STEP
