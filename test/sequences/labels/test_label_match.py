from pathlib import Path

import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.source import open_source


@pytest.fixture
def truth_of(pictures):
    """Return a function that writes labels of the given names beside the pictures."""

    def write(*names):
        path = pictures / "truth.txt"
        path.write_text("# a comment\n" + "".join(f"1 0.1 30 0 # {name}\n" for name in names))
        return path

    return write


def test_labels_are_found_by_the_names_of_their_pictures(pictures, truth_of):
    with open_source(pictures, truth=truth_of("2.png", "0.png")) as source:
        labelled = [frame.index for frame in source.frames() if frame.truth is not None]
    assert labelled == [0, 2]


@pytest.mark.parametrize("named", [".", "metadata.yaml", "../bag/", "../bag/../bag"])
def test_a_recording_has_the_name_of_its_folder_however_it_is_given(
    monkeypatch, make_bag, truth_of, named
):
    truth = truth_of("other:1", "bag:2", "old/bag:3")
    monkeypatch.chdir(make_bag(truth=False))
    with open_source(Path(named), truth=truth) as source:
        assert [frame.index for frame in source.frames() if frame.truth is not None] == [2]


def test_a_label_without_a_frame_is_named(pictures, truth_of):
    truth = truth_of("0.png", "missing.png")
    with pytest.raises(RecordingError, match=r"line 3 labels missing\.png, which is no picture in"):
        open_source(pictures, truth=truth)


def test_a_label_beyond_the_last_frame_is_named(pictures, truth_of):
    truth = truth_of("any.mp4:3", "any.mp4:4")
    with pytest.raises(RecordingError, match=r"line 3 labels any\.mp4:4.*only 4 frames"):
        open_source(pictures, truth=truth)


def test_a_label_beyond_the_end_of_a_video_is_named(make_video, truth_of):
    with pytest.raises(RecordingError, match=r"labels dive\.avi:10.*only 10 frames"):
        open_source(make_video(), truth=truth_of("dive.avi:10"))


def test_a_label_beyond_the_end_is_named_after_the_last_frame_where_the_end_is_not_known(
    make_video, truth_of
):
    source = open_source(make_video("dive.mkv"), truth=truth_of("dive.mkv:9", "dive.mkv:10"))
    seen = []
    with pytest.raises(RecordingError, match=r"only 10 frames.* frame 10 is labelled"):
        seen.extend(source.frames())
    assert len(seen) == 10
    later = open_source(make_video("dive.mkv"), truth=truth_of("dive.mkv:9")).frames(start=8)
    assert [frame.truth is None for frame in later] == [True, False]


def test_a_label_without_a_number_is_none_of_a_frame_of_a_bag(make_bag, truth_of):
    with pytest.raises(RecordingError, match=r"line 2 labels bag, which is no .*FILE:FRAME"):
        open_source(make_bag(truth=False), truth=truth_of("bag", "bag:3"))


@pytest.mark.parametrize("name", ["dive.avi: 3", "dive.avi:three", "dive.avi:-1", "dive.avi"])
def test_what_is_no_number_of_a_frame_is_malformed(make_video, truth_of, name):
    with pytest.raises(RecordingError, match=r"line 3 is malformed .*dive\.avi"):
        open_source(make_video(), truth=truth_of("dive.avi:2", name))


def test_a_picture_may_be_named_after_a_frame_of_a_video(pictures, truth_of):
    (pictures / "0.png").rename(pictures / "dive.avi:0.png")
    assert open_source(pictures, truth=truth_of("dive.avi:0.png")).has_truth


def test_labels_of_frames_that_a_sequence_file_does_not_list_are_not_taken_for_others(
    make_video, truth_of
):
    folder = make_video().parent
    listed = folder / "listed.txt"
    listed.write_text("9 0.1 30 0 # dive.avi:5\n9 0.1 30 0 # dive.avi:7\n")
    with pytest.raises(RecordingError, match="none for a frame that"):
        open_source(listed, truth=truth_of("dive.avi:1"))
    with open_source(listed, truth=truth_of("dive.avi:1", "dive.avi:7")) as source:
        labelled = [frame.index for frame in source.frames() if frame.truth is not None]
    assert labelled == [1]


def test_a_second_label_of_a_frame_is_named(pictures, truth_of):
    with pytest.raises(RecordingError, match=r"line 4 labels 1\.png again, after line 3"):
        open_source(pictures, truth=truth_of("0.png", "1.png", "1.png"))


def test_labels_that_name_files_elsewhere_are_checked_where_that_is_allowed(pictures, truth_of):
    truth = truth_of("../any.mp4:3", "../any.mp4:4")
    with pytest.raises(RecordingError, match="--allow-outside"):
        open_source(pictures, truth=truth)
    with pytest.raises(RecordingError, match=r"line 3 labels .*any\.mp4:4.*only 4 frames"):
        open_source(pictures, truth=truth, allow_outside=True)
    source = open_source(pictures, truth=truth_of("../any.mp4:3"), allow_outside=True)
    assert source.has_truth


@pytest.mark.parametrize("width", [0, -3])
def test_a_label_without_a_width_is_refused(pictures, width):
    truth = pictures / "truth.txt"
    truth.write_text(f"1 0.1 {width} 0 # 0.png\n")
    with pytest.raises(RecordingError, match=f"line 1 is malformed .w is {width} px"):
        open_source(pictures, truth=truth)
