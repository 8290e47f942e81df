from __future__ import annotations

import math

import av
import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import OutputError, RecordingError
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.labels.sequence_file import (
    APART,
    Label,
    read_labels,
    write_labels,
)
from cable_tracker.sequences.source import open_source
from cable_tracker.stamps import FIRST_STAMP

numbers = st.floats(-1e6, 1e6)
widths = st.floats(0.0, 1e6, exclude_min=True)
angles = st.floats(-math.pi / 2, math.pi / 2, exclude_min=True)
names = st.from_regex(r"[a-zA-Z0-9_][a-zA-Z0-9_ .#-]{0,20}\.png", fullmatch=True)
labels = st.builds(
    Label,
    names,
    st.none() | st.integers(0, 10**6),
    state=st.builds(CableState, numbers, angles, widths, angles),
)


@pytest.fixture
def write(tmp_path):
    """Write a sequence file of the given lines."""

    def write_lines(*lines: str):
        path = tmp_path / "sequence.txt"
        path.write_text("\n".join(lines) + "\n")
        return path

    return write_lines


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.lists(labels, min_size=1, max_size=5))
def test_labels_are_read_as_they_were_written(tmp_path, written):
    write_labels(tmp_path / "s.txt", written)
    assert read_labels(tmp_path / "s.txt") == written


def test_the_format_of_the_thesis(write):
    path = write(
        "# CableDistance CableAngle CableWidth CableSkew # Filename",
        "",
        "-12.5 0.25 40 0.01 # pictures/a b.png",
        "  #not a label",
        "1e1\t-.5 4.0e1 0 #dive.mp4:12",
    )
    assert read_labels(path) == [
        Label("pictures/a b.png", state=CableState(-12.5, 0.25, 40.0, 0.01)),
        Label("dive.mp4", 12, state=CableState(10.0, -0.5, 40.0, 0.0)),
    ]


def test_an_angle_beyond_the_wrap_is_the_same_line(write):
    (label,) = read_labels(write(f"10 {math.pi / 2 + 0.1} 40 0.02 # a.png"))
    assert label.state.angle == pytest.approx(-math.pi / 2 + 0.1)
    assert (label.state.distance, label.state.skew) == (-10.0, -0.02)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("1 2 3 # a.png", "3 numbers"),
        ("1 2 3 4 5 # a.png", "5 numbers"),
        ("1 2 x 4 # a.png", "could not convert"),
        ("1 0.2 3 0.4", "file name"),
        ("1 0.2 3 0.4 #  ", "file name"),
        ("nan 0.2 3 0.4 # a.png", "not finite"),
        ("1 0.2 inf 0.4 # a.png", "not finite"),
        ("1 -1e12 3 0.4 # a.png", "alpha is -1e"),
        ("1 -18.9 30 0.9 # a.png", "alpha is -18.9; alpha and beta are in radians, not degrees"),
        ("1 0.2 30 -1.7 # a.png", "beta is -1.7; alpha and beta are in radians, not degrees"),
        ("1 0.2 3 0.4 # /etc/passwd", "outside"),
        ("1 0.2 3 0.4 # ../a.png", "outside"),
        ("1 0.2 3 0.4 # a/../../b.mp4:3", "outside"),
        ("1 0.2 3 0.4 # a\0.png", "outside"),
    ],
)
def test_a_malformed_line_is_named(write, line, reason):
    path = write("# comment", "1 0.2 3 0.4 # a.png", line)
    with pytest.raises(RecordingError, match=rf"sequence\.txt: line 3 is malformed \(.*{reason}"):
        read_labels(path)


def test_a_file_without_labels_is_refused(write):
    with pytest.raises(RecordingError, match="no labels"):
        read_labels(write("# only a comment"))


@pytest.mark.parametrize("length", [1, 100, 100_000])
def test_garbage_is_refused(tmp_path, length):
    path = tmp_path / "x.txt"
    path.write_bytes(b"\xff" + np.random.default_rng(0).bytes(length))
    with pytest.raises(RecordingError, match=r"x\.txt") as caught:
        read_labels(path)
    assert len(str(caught.value)) < 1000
    assert "\n" not in str(caught.value)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.binary(max_size=200) | st.text(alphabet="0123456789.- #:ab/\n", max_size=80))
def test_any_file_is_read_or_refused(tmp_path, content):
    path = tmp_path / "x.txt"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    try:
        list(open_source(path).frames())
    except RecordingError as error:
        assert "\n" not in str(error)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(RecordingError, match=r"x\.txt"):
        read_labels(tmp_path / "x.txt")


@pytest.mark.parametrize("name", ["/a.png", "../a.png", "a\nb.png", "a.png:3", " a.png", ""])
def test_a_name_that_would_not_be_read_back_is_not_written(tmp_path, name):
    with pytest.raises(OutputError):
        write_labels(tmp_path / "s.txt", [Label(name, state=CableState(1, 0, 2))])


def test_labels_cannot_be_written_to_a_missing_folder(tmp_path):
    with pytest.raises(OutputError, match="nothing"):
        write_labels(tmp_path / "nothing" / "s.txt", [])


@pytest.mark.parametrize(
    ("name", "frame"),
    [("rec at 3.04\u202fPM.mp4", 4), ("a\u00a0b.png", None), ("Tauchgang ä #2.png", None)],
)
def test_names_with_blanks_of_any_kind_are_read_back(tmp_path, name, frame):
    labels = [Label(name, frame, state=CableState(1, 0, 2))]
    write_labels(tmp_path / "s.txt", labels)
    assert read_labels(tmp_path / "s.txt") == labels


def test_a_name_that_cannot_be_written_asks_for_another_name_and_not_for_room(tmp_path):
    with pytest.raises(OutputError, match="rename the recording"):
        write_labels(tmp_path / "s.txt", [Label(" lead.mp4", state=CableState(1, 0, 2))])


def test_pictures_are_read_in_the_order_of_the_list(write, tmp_path, picture):
    (tmp_path / "in").mkdir()
    for index in range(3):
        cv2.imwrite(str(tmp_path / "in" / f"{index}.png"), picture(index))
    path = write(*(f"{index} 0 30 0 # in/{index}.png" for index in (2, 0, 1)))
    with open_source(path, rate=10.0) as source:
        frames = list(source.frames())
    assert [frame.stamp - FIRST_STAMP for frame in frames] == [0, 100_000_000, 200_000_000]
    assert [frame.index for frame in frames] == [0, 1, 2]
    assert [int(decode_grey(frame.image)[0, 0]) for frame in frames] == [2, 0, 1]
    assert [frame.truth.distance for frame in frames] == [2.0, 0.0, 1.0]
    assert source.has_truth
    assert source.frame_count == 3


def test_frames_of_a_video_are_picked(write, make_video):
    make_video("dive.avi")
    path = write(*(f"{number} 0 30 0 # dive.avi:{number}" for number in (1, 4, 9, 3, 3)))
    frames = list(open_source(path).frames())
    assert [frame.stamp - FIRST_STAMP for frame in frames] == [
        n * 50_000_000 for n in (1, 4, 9, 3, 3)
    ]
    brightness = [float(decode_grey(frame.image).mean()) for frame in frames]
    np.testing.assert_allclose(brightness, [10, 40, 90, 30, 30], atol=4)
    assert [frame.truth.distance for frame in frames] == [1, 4, 9, 3, 3]


def test_frames_of_a_video_have_the_times_they_have_in_it(write, write_video):
    write_video("dive.mkv", [0, 40, 80, 8080, 8120])
    source = open_source(write("0 0 30 0 # dive.mkv:1", "0 0 30 0 # dive.mkv:4"))
    assert [frame.stamp - FIRST_STAMP for frame in source.frames()] == [40_000_000, 8_120_000_000]


def test_a_note_names_a_video_whose_times_are_not_used(write, write_video):
    path = write_video("dive.ts", [40 * index for index in range(30)])
    path.write_bytes(path.read_bytes() * 2)
    source = open_source(write("0 0 30 0 # dive.ts:40"))
    assert next(source.frames()).stamp - FIRST_STAMP == 1_600_000_000
    assert source.note.startswith("dive.ts: its times repeat")


def test_a_video_is_read_in_one_pass(write, make_video, monkeypatch):
    make_video("dive.avi")
    source = open_source(write(*(f"0 0 30 0 # dive.avi:{n}" for n in range(10))))
    opened = []
    av_open = av.open
    monkeypatch.setattr(av, "open", lambda *a, **k: opened.append(a) or av_open(*a, **k))
    assert len(list(source.frames())) == 10
    assert len(opened) == 1


def test_pictures_and_videos_may_be_mixed(write, make_video, tmp_path, picture):
    make_video("dive.avi")
    cv2.imwrite(str(tmp_path / "a.png"), picture(1))
    path = write("0 0 30 0 # dive.avi:2", "1 0 30 0 # a.png", "2 0 30 0 # dive.avi:3")
    frames = list(open_source(path).frames())
    assert [frame.truth.distance for frame in frames] == [0, 1, 2]


def test_recordings_of_a_list_are_separated_by_a_gap_in_time(write, make_video):
    make_video("a.avi")
    make_video("b.avi")
    source = open_source(write(*(f"0 0 30 0 # {name}.avi:{k}" for name in "ab" for k in (3, 4))))
    steps = np.diff([frame.stamp for frame in source.frames()])
    assert steps.tolist() == [50_000_000, APART - 50_000_000, 50_000_000]
    assert "several recordings" in source.note


def test_pictures_keep_the_times_of_their_numbers(write, picture, tmp_path):
    for number in (1, 2, 3, 7):
        cv2.imwrite(str(tmp_path / f"frame_{number}.png"), picture(1))
    source = open_source(write(*(f"0 0 30 0 # frame_{k}.png" for k in (1, 2, 3, 7))))
    stamps = [frame.stamp - FIRST_STAMP for frame in source.frames()]
    assert stamps == [0, 40_000_000, 80_000_000, 240_000_000]
    assert "numbered with gaps" in source.note


def test_pictures_in_any_order_follow_each_other(write, picture, tmp_path):
    for number in (1, 2, 7):
        cv2.imwrite(str(tmp_path / f"frame_{number}.png"), picture(1))
    source = open_source(write(*(f"0 0 30 0 # frame_{k}.png" for k in (7, 1, 2))))
    stamps = [frame.stamp - FIRST_STAMP for frame in source.frames()]
    assert stamps == [0, 40_000_000, 80_000_000]


def test_a_frame_beyond_the_end_of_the_video_is_damage(write, make_video):
    make_video("dive.avi")
    source = open_source(write("0 0 30 0 # dive.avi:2", "0 0 30 0 # dive.avi:10"))
    frames = source.frames()
    next(frames)
    with pytest.raises(RecordingError, match=r"after 1 frames \(dive.avi has only 10 frames\)"):
        next(frames)


def test_a_bad_frame_of_a_video_is_reported_by_its_number_there(write, make_video):
    path = make_video("dive.avi")
    with av.open(str(path)) as container:
        packets = [(packet.pos, packet.size) for packet in container.demux(video=0)]
    data, (place, size) = bytearray(path.read_bytes()), packets[5]
    data[place + 8 : place + size] = bytes(size - 8)
    path.write_bytes(data)
    source = open_source(write("0 0 30 0 # dive.avi:2", "0 0 30 0 # dive.avi:8"))
    with pytest.raises(RecordingError, match=r"frame 5 that cannot be decoded: Invalid"):
        list(source.frames())


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("0 0 30 0 # missing.png", "missing.png is missing"),
        ("0 0 30 0 # dive.avi", "name the frame"),
        ("0 0 30 0 # a.png:3", "no video"),
        ("0 0 30 0 # link.png", "outside"),
        ("0 0 30 0 # linked/secret.png", "outside"),
        ("0 0 30 0 # loop.png", "loop.png"),
    ],
)
def test_a_name_that_cannot_be_used_is_refused(write, make_video, tmp_path, line, reason):
    make_video("dive.avi")
    outside = tmp_path.parent / f"{tmp_path.name}_outside"
    outside.mkdir()
    (outside / "secret.png").write_bytes(b"x")
    (tmp_path / "link.png").symlink_to(outside / "secret.png")
    (tmp_path / "linked").symlink_to(outside)
    (tmp_path / "loop.png").symlink_to(tmp_path / "loop.png")
    (tmp_path / "a.png").write_bytes(b"x")
    with pytest.raises(RecordingError, match=reason):
        open_source(write(line))


@pytest.mark.parametrize("name", ["{outside}/far.png", "../{parent}/far.png", "link.png"])
def test_a_file_that_is_trusted_may_name_others_outside_its_folder(write, tmp_path, name):
    outside = tmp_path.parent / f"{tmp_path.name}_outside"
    outside.mkdir()
    cv2.imwrite(str(outside / "far.png"), np.full((4, 6), 9, np.uint8))
    (tmp_path / "link.png").symlink_to(outside / "far.png")
    path = write(f"0 0 30 0 # {name.format(outside=outside, parent=outside.name)}")
    with pytest.raises(RecordingError, match=r"--allow-outside \(node: allow_outside\)"):
        open_source(path)
    with open_source(path, allow_outside=True) as source:
        assert [frame.image.width for frame in source.frames()] == [6]


def test_a_long_name_outside_the_folder_does_not_cut_off_what_to_do(write):
    path = write(f"0 0 30 0 # /{'x' * 180}.png")
    with pytest.raises(RecordingError, match="--allow-outside"):
        open_source(path)


def test_the_labels_of_the_real_footage_are_read(footage):
    labels = read_labels(footage / "strip.txt")
    assert len(labels) == 138
    assert labels[0] == Label("strip.mp4", 0, state=CableState(199.97, -0.44943, 118.35, 0.00114))
    with open_source(footage / "strip.txt") as source:
        frames = list(source.frames())
    assert len(frames) == source.frame_count == 138
    assert frames[-1].stamp - FIRST_STAMP == 238 * 40_000_000
    assert all(frame.truth is not None for frame in frames)


def test_a_label_knows_its_line_behind_comments_and_empty_lines(tmp_path):
    path = tmp_path / "labels.txt"
    path.write_text("# head\n1 2 3 0.4 # a\n\n  # note\n1 2 3 0.4 # b\n")
    assert [label.line for label in read_labels(path)] == [2, 5]


def test_a_picture_that_cannot_be_read_keeps_its_label(write, tmp_path):
    (tmp_path / "torn.png").write_bytes(b"garbage")
    path = write("-12.5 0.25 40 0.01 # torn.png")
    with open_source(path, skip_bad_frames=True) as source:
        (frame,) = source.frames()
    assert frame.truth == CableState(-12.5, 0.25, 40.0, 0.01)
