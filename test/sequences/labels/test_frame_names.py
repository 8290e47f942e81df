from pathlib import Path

import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import RecordingError
from cable_tracker.sequences.labels.frame_names import EntryNames, NumberedNames, PictureNames
from cable_tracker.sequences.labels.sequence_file import FrameName, Label


def label(name, frame=None):
    return Label(name, frame, state=CableState(0.0, 0.0, 9.0))


@pytest.fixture
def video(tmp_path):
    return NumberedNames(tmp_path / "dive.avi")


@pytest.fixture
def folder(tmp_path):
    return PictureNames(tmp_path / "dive", [f"{number:03d}.png" for number in range(9)])


@pytest.fixture
def sequence(tmp_path):
    return EntryNames(tmp_path / "s.txt", [label(f"dive/{number:03d}.png") for number in range(3)])


@pytest.fixture(params=["video", "folder", "sequence"])
def names(request):
    """Names of the frames of each kind of recording."""
    return request.getfixturevalue(request.param)


def test_a_video_is_named_as_it_lies_from_the_label_file(video, tmp_path):
    assert video.name(7, tmp_path) == FrameName("dive.avi", 7)
    assert video.name(7, tmp_path.parent) == FrameName(f"{tmp_path.name}/dive.avi", 7)


def test_a_video_elsewhere_is_named_without_its_folder(video, tmp_path):
    assert video.name(7, tmp_path / "labels") == FrameName("dive.avi", 7)


def test_pictures_go_by_their_names(folder, tmp_path):
    assert folder.name(7, tmp_path) == FrameName("dive/007.png")
    assert folder.name(7, tmp_path / "dive") == FrameName("007.png")
    assert folder.name(7, tmp_path / "labels") == FrameName("dive/007.png")


def test_frames_of_a_sequence_file_keep_their_names(sequence, tmp_path):
    assert sequence.name(2, tmp_path / "labels") == FrameName("dive/002.png")


@pytest.mark.parametrize("below", ["", "dive", "labels"])
def test_names_lead_back_to_their_frames(names, tmp_path, below):
    named = [names.name(frame, tmp_path / below) for frame in (2, 0, 1)]
    assert names.frames(named, tmp_path / "labels.txt") == [2, 0, 1]


def test_labels_of_other_recordings_are_no_frames(video):
    labels = [label("dive.avi", 3), label("other.avi", 4), label("dive.avi")]
    assert video.frames(labels, Path("labels.txt")) == [3, None, None]


def test_a_single_other_name_is_the_recording_before_it_was_renamed(video):
    labels = [label("before.avi", 3), label("before.avi", 4)]
    assert video.frames(labels, Path("labels.txt")) == [3, 4]


def test_a_file_about_other_recordings_only_is_refused(names):
    labels = [label("a/strange.png"), label("b/stranger.png")]
    with pytest.raises(RecordingError, match=r"labels\.txt: holds labels, but none for"):
        names.frames(labels, Path("labels.txt"))


def test_labels_of_another_folder_are_of_no_picture_here(tmp_path):
    names = PictureNames(tmp_path / "day1", ["0.png", "1.png"])
    state = CableState(1.0, 0.0, 20.0)
    labels = [Label(name, state=state) for name in ("day1/0.png", "day2/0.png", "day1/1.png")]
    assert names.frames(labels, tmp_path / "truth.txt") == [0, None, 1]


def test_labels_of_a_recording_of_that_name_in_another_folder_are_not_its_own(video, tmp_path):
    labels = [label(f"{tmp_path.name}/dive.avi", 3), label("day2/dive.avi", 4)]
    assert video.frames(labels, tmp_path.parent / "labels.txt") == [3, None]


def test_labels_of_two_recordings_either_of_which_may_be_this_one_are_refused(video, folder):
    labels = [label("day1/dive.avi", 3), label("day2/dive.avi", 4)]
    with pytest.raises(
        RecordingError, match=r"labels day1/dive\.avi and day2/dive\.avi, either of"
    ):
        video.frames(labels, Path("labels.txt"))
    with pytest.raises(RecordingError, match=r"labels a/001\.png and b/001\.png, either of"):
        folder.frames([label("a/001.png"), label("b/001.png")], Path("labels.txt"))


def test_labels_of_another_recording_that_is_there_are_not_its_own(video, tmp_path):
    (tmp_path / "other.avi").write_bytes(b"another dive")
    with pytest.raises(RecordingError, match="holds labels, but none for"):
        video.frames([label("other.avi", 3)], tmp_path / "labels.txt")


def test_a_picture_that_is_missing_is_known_by_the_folder_of_others(folder, tmp_path):
    named = ["dive/001.png", "dive/gone.png", "other/gone.png"]
    own = folder.own_frames(list(map(label, named)), tmp_path / "labels.txt")
    assert own == {"dive/001.png": 1, "dive/gone.png": None}


def test_a_sequence_that_lists_a_frame_twice_is_refused(tmp_path):
    entries = [label("p0.png"), label("p1.png"), label("p0.png")]
    with pytest.raises(RecordingError, match=r"p0\.png 2 times"):
        EntryNames(tmp_path / "s.txt", entries)
