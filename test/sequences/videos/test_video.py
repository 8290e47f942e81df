from __future__ import annotations

import os
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from av.video.reformatter import Colorspace

from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences.encodings import decode_bgr, decode_grey
from cable_tracker.sequences.source import open_source
from cable_tracker.stamps import FIRST_STAMP, stamp_of_frame

SUFFIXES = [".avi", ".mp4", ".mkv", ".webm"]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_all_frames_are_read_in_order(make_video, suffix):
    source = open_source(make_video(f"dive{suffix}"))
    frames = list(source.frames())
    assert [frame.index for frame in frames] == list(range(10))
    assert [frame.stamp - FIRST_STAMP for frame in frames] == [
        index * 50_000_000 for index in range(10)
    ]
    brightness = [float(decode_grey(frame.image).mean()) for frame in frames]
    np.testing.assert_allclose(brightness, np.arange(10) * 10.0, atol=4.0)


def test_frames_are_colour(make_video):
    image = next(open_source(make_video()).frames()).image
    assert (image.encoding, image.width, image.height) == ("bgr8", 64, 48)


def test_a_video_describes_its_content(make_video):
    source = open_source(make_video(rate=30.0))
    assert source.frame_count == 10
    assert not source.has_truth
    assert not source.compressed


def test_a_container_without_frame_count_does_not_promise_any(make_video):
    assert open_source(make_video("dive.webm")).frame_count is None


def test_every_pass_over_the_frames_begins_at_the_first(make_video):
    source = open_source(make_video())
    with source:
        next(source.frames())
        assert len(list(source.frames())) == 10


def test_stamps_do_not_drift():
    assert stamp_of_frame(30_000, 29.97) == FIRST_STAMP + round(30_000 * 1e9 / 29.97)


def test_a_video_that_players_turn_is_read_as_it_is_stored(write_video):
    upright, turned = (
        write_video(name, [0, 40], turn=turn) for name, turn in (("a.mp4", 0), ("b.mp4", 90))
    )
    pictures = [decode_grey(next(open_source(path).frames()).image) for path in (upright, turned)]
    np.testing.assert_array_equal(*pictures)
    assert open_source(upright).note == ""
    assert "read as it is stored" in open_source(turned).note


def test_a_video_whose_name_is_not_utf_8_is_refused(make_video):
    # FFmpeg takes names in UTF-8.
    path = make_video().rename(os.fsdecode(os.fsencode(make_video()) + b"\xe4.mp4"))
    with pytest.raises(RecordingError, match=r"not UTF-8 .*rename"):
        open_source(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_time_of_day_in_a_name_is_no_protocol(monkeypatch, make_video, suffix):
    video = make_video(f"2026-11-27T12:30:00{suffix}")
    monkeypatch.chdir(video.parent)
    source = open_source(Path(video.name))
    assert len(list(source.frames())) == 10
    assert source.note == ""


def test_a_missing_video_is_refused(tmp_path):
    with pytest.raises(RecordingError, match=r"x\.mp4"):
        open_source(tmp_path / "x.mp4")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("length", [0, 1, 10_000])
def test_garbage_is_refused(tmp_path, suffix, length):
    path = tmp_path / f"x{suffix}"
    path.write_bytes(np.random.default_rng(0).bytes(length))
    with pytest.raises(RecordingError, match=rf"x\{suffix}") as caught:
        list(open_source(path).frames())
    assert "\n" not in str(caught.value)


def test_a_video_cut_before_its_index_is_refused(make_video):
    path = make_video("dive.mp4")
    os.truncate(path, path.stat().st_size // 2)
    with pytest.raises(RecordingError, match="truncated"):
        open_source(path)


def test_frames_before_the_cut_are_delivered(make_video):
    path = make_video("dive.avi", frames=50)
    os.truncate(path, path.stat().st_size // 2)
    source = open_source(path)
    frames = []
    if source.frame_count is None:
        pytest.skip("this OpenCV does not know the number of frames of a cut avi")
    with pytest.raises(RecordingError, match=r"damaged after \d+ frames .* promises 50"):
        for frame in source.frames():
            frames.append(frame)
    assert 10 < len(frames) < 40


def test_ffmpeg_does_not_write_to_the_terminal(make_video):
    path = make_video("dive.mp4", frames=30)
    data = bytearray(path.read_bytes())
    start = data.index(b"mdat") + 200
    data[start : start + 300] = np.random.default_rng(0).bytes(300)
    path.write_bytes(data)
    code = (
        "from pathlib import Path\n"
        "from cable_tracker.sequences.source import open_source\n"
        f"try:\n    list(open_source(Path({str(path)!r})).frames())\n"
        "except Exception: pass\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True
    )
    assert ran.stderr == ""
    assert ran.stdout == ""


def test_the_real_footage_has_240_frames(footage):
    source = open_source(footage / "strip.mp4")
    assert source.frame_count == 240
    frames = source.frames()
    first = next(frames)
    assert (first.image.width, first.image.height) == (1280, 720)
    assert 1 + sum(1 for _ in frames) == 240


def test_a_video_of_too_many_pixels_is_refused_before_it_is_decoded(monkeypatch, make_video):
    path = make_video()
    monkeypatch.setattr("cable_tracker.sequences.videos.video_frames.MAX_PIXELS", 100)
    with pytest.raises(RecordingError, match="more than the 100 allowed"):
        open_source(path)


def test_a_frame_of_too_many_pixels_is_a_bad_frame(monkeypatch, make_video):
    path = make_video()
    monkeypatch.setattr("cable_tracker.sequences.encodings.MAX_PIXELS", 100)
    with pytest.raises(RecordingError, match="skip-bad-frames"):
        next(open_source(path).frames())
    frame = next(open_source(path, skip_bad_frames=True).frames())
    with pytest.raises(FrameError):
        decode_grey(frame.image)


def write_matroska(path, frames, *, seconds_of_sound=0):
    """Write a video as most programs do, with how long each stream lasts."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        sound = container.add_stream("pcm_s16le", rate=8000) if seconds_of_sound else None
        noise = np.random.default_rng(0)
        for _ in range(frames):
            picture = noise.integers(0, 255, (48, 64, 3), np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        container.mux(stream.encode(None))
        for second in range(seconds_of_sound):
            silence = av.AudioFrame.from_ndarray(np.zeros((1, 8000), np.int16), layout="mono")
            silence.sample_rate, silence.pts = 8000, 8000 * second
            container.mux(sound.encode(silence))
    return path


def test_the_cut_of_a_matroska_file_is_reported_after_the_frames_before_it(tmp_path):
    path = write_matroska(tmp_path / "dive.mkv", 100)
    assert len(list(open_source(path).frames())) == 100
    os.truncate(path, path.stat().st_size // 2)
    frames = []
    with pytest.raises(RecordingError, match=r"damaged after \d+ frames .* promises 4\.0 s"):
        for frame in open_source(path).frames():
            frames.append(frame)
    assert 30 < len(frames) < 70


def test_sound_that_lasts_longer_than_the_pictures_is_no_damage(tmp_path):
    path = write_matroska(tmp_path / "dive.mkv", 25, seconds_of_sound=4)
    assert len(list(open_source(path).frames())) == 25


def test_frames_that_an_edit_list_leaves_out_are_not_missing(tmp_path):
    path = tmp_path / "cut.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        packets = []
        for index in range(30):
            picture = np.full((48, 64, 3), 8 * index, np.uint8)
            packets += stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24"))
        packets += stream.encode(None)
        before = round(10 / 25 / packets[0].time_base)
        for packet in packets:
            packet.pts, packet.dts = packet.pts - before, packet.dts - before
            container.mux(packet)
    assert len(list(open_source(path).frames())) == 20


PAUSED = [40 * number for number in (*range(30), *range(150, 180))]
"""Times of frames between which a recorder paused [ms]; an AVI holds empty ones there."""


def test_the_empty_frames_of_an_avi_whose_recorder_paused_are_not_missing(write_video):
    path = write_video("dive.avi", PAUSED, codec="mpeg4", ticks=25)
    assert milliseconds(open_source(path)) == PAUSED


def test_the_cut_of_an_avi_after_a_pause_is_reported(write_video):
    path = write_video("dive.avi", PAUSED, codec="mpeg4", ticks=25)
    os.truncate(path, path.stat().st_size * 3 // 4)
    with pytest.raises(RecordingError, match=r"damaged after 4\d frames"):
        list(open_source(path).frames())


@pytest.mark.parametrize("standard", [Colorspace.ITU601, Colorspace.ITU709])
def test_colours_are_those_of_the_standard_that_the_video_names(tmp_path, standard):
    # Read by the other one, the green would be off by 20 levels.
    colour = np.full((48, 64, 3), (60, 160, 90), np.uint8)
    path = tmp_path / "dive.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25, options={"qp": "1"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.codec_context.colorspace = {Colorspace.ITU709: 1}.get(standard, 6)
        frame = av.VideoFrame.from_ndarray(colour, format="bgr24")
        coded = frame.reformat(format="yuv420p", dst_colorspace=standard)
        container.mux(stream.encode(coded))
        container.mux(stream.encode(None))
    picture = decode_bgr(next(open_source(path).frames()).image)
    np.testing.assert_allclose(picture, colour, atol=4)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("dive.mkv", "promises 4"),
        ("dive.mp4", "cannot be decoded: .* promises 100"),
        ("dive.avi", "cannot be decoded: .* promises 100"),
    ],
)
def test_frames_end_before_the_first_that_cannot_be_decoded(tmp_path, name, reason):
    # All others would have the number, and so the label, of the frame before.
    path = write_matroska(tmp_path / name, 100)
    with av.open(str(path)) as container:
        packets = [(packet.pos, packet.size) for packet in container.demux(video=0) if packet.size]
    data, (place, size) = bytearray(path.read_bytes()), packets[50]
    data[place : place + size] = bytes([255]) * size
    path.write_bytes(data)
    frames = []
    with pytest.raises(RecordingError, match=rf"damaged after \d+ frames .*{reason}"):
        for frame in open_source(path).frames():
            frames.append(frame)
    assert 40 < len(frames) <= 55


VARIABLE = [0, 40, 80, 120, 160, 200, 8200, 8240, 8280]
"""Times of frames with a gap [ms]."""


@pytest.mark.parametrize("first", [0, 10_000])
@pytest.mark.parametrize("suffix", [".mp4", ".mov", ".mkv", ".ts"])
@pytest.mark.parametrize("b_frames", [0, 3])
def test_frames_of_a_variable_rate_have_the_times_of_the_container(
    write_video, suffix, b_frames, first
):
    times = [first + time for time in VARIABLE]
    source = open_source(write_video(f"dive{suffix}", times, b_frames=b_frames))
    assert milliseconds(source) == VARIABLE
    assert milliseconds(source, start=7) == VARIABLE[7:]
    assert not source.note


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".ts"])
@pytest.mark.parametrize("rate", [Fraction(30000, 1001), Fraction(25)])
def test_stamps_of_a_constant_rate_are_exact_in_spite_of_b_frames(write_video, suffix, rate):
    times = [round(index * 1000 / rate) for index in range(50)]
    if suffix != ".mkv":
        times = [index * 1000 / rate for index in range(50)]
    path = write_video(f"dive{suffix}", times, b_frames=3, rate=rate)
    stamps = [frame.stamp for frame in open_source(path).frames()]
    assert stamps == [stamp_of_frame(index, float(rate)) for index in range(50)]


def test_frames_without_times_after_the_last_key_frame_of_an_avi_are_steady(write_video):
    times = [40 * index for index in range(30)]
    path = write_video("dive.avi", times, codec="mpeg4", b_frames=2, ticks=25)
    assert milliseconds(open_source(path)) == times


def test_a_clock_that_restarts_leaves_the_steady_rate_and_a_note(write_video):
    path = write_video("dive.ts", [0, 40, 80, *(8000 + 40 * index for index in range(27))])
    path.write_bytes(path.read_bytes() * 2)
    source = open_source(path)
    assert milliseconds(source) == [40 * index for index in range(60)]
    assert "repeat or run backwards" in source.note


def test_a_program_stream_in_which_some_frames_have_no_time_is_steady(write_video):
    times = [40 * index for index in range(60)]
    source = open_source(write_video("dive.mpg", times, codec="mpeg2video", ticks=25))
    assert milliseconds(source) == times


def test_a_clock_that_restarts_later_goes_on_at_the_steady_rate(write_video):
    path = write_video("dive.ts", [40 * index for index in range(300)])
    path.write_bytes(path.read_bytes() * 2)
    stamps = milliseconds(open_source(path))
    assert stamps == [40 * index for index in range(600)]


def milliseconds(source, start=0):
    return [(frame.stamp - FIRST_STAMP) / 1e6 for frame in source.frames(start)]
