from pathlib import Path

import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import RecordingError
from cable_tracker.gui.labelling.names import EntryNames, PictureNames, names_of
from cable_tracker.sequences.labels.sequence_file import Label
from cable_tracker.sequences.source import open_source


def label(name, frame=None):
    return Label(CableState(0.0, 0.0, 9.0), name, frame)


@pytest.fixture
def names(request):
    return names_of(open_source(request.getfixturevalue(request.param)))


videos = pytest.mark.parametrize("names", ["video"], indirect=True)
folders = pytest.mark.parametrize("names", ["folder"], indirect=True)
sequences = pytest.mark.parametrize("names", ["sequence"], indirect=True)


@videos
def test_a_video_is_named_as_it_lies_from_the_label_file(names, tmp_path):
    assert names.name(7, tmp_path) == ("dive.avi", 7)
    assert names.name(7, tmp_path.parent) == (f"{tmp_path.name}/dive.avi", 7)


@videos
def test_a_video_elsewhere_is_named_without_its_folder(names, tmp_path):
    assert names.name(7, tmp_path / "labels") == ("dive.avi", 7)


@folders
def test_pictures_go_by_their_names(names, tmp_path):
    assert names.name(7, tmp_path) == ("dive/007.png", None)
    assert names.name(7, tmp_path / "dive") == ("007.png", None)
    assert names.name(7, tmp_path / "labels") == ("dive/007.png", None)


@sequences
def test_frames_of_a_sequence_file_keep_their_names(names, tmp_path):
    assert names.name(2, tmp_path / "labels") == ("dive/002.png", None)


@pytest.mark.parametrize("names", ["video", "folder", "sequence"], indirect=True)
@pytest.mark.parametrize("below", ["", "dive", "labels"])
def test_names_lead_back_to_their_frames(names, tmp_path, below):
    named = [label(*names.name(frame, tmp_path / below)) for frame in (2, 0, 1)]
    assert names.frames(named, tmp_path / "labels.txt") == [2, 0, 1]


@videos
def test_labels_of_other_recordings_are_no_frames(names):
    labels = [label("dive.avi", 3), label("other.avi", 4), label("dive.avi")]
    assert names.frames(labels, Path("labels.txt")) == [3, None, None]


@videos
def test_a_single_other_name_is_the_recording_before_it_was_renamed(names):
    labels = [label("before.avi", 3), label("before.avi", 4)]
    assert names.frames(labels, Path("labels.txt")) == [3, 4]


@pytest.mark.parametrize("names", ["video", "folder", "sequence"], indirect=True)
def test_a_file_about_other_recordings_only_is_refused(names):
    labels = [label("a/strange.png"), label("b/stranger.png")]
    with pytest.raises(RecordingError, match=r"labels\.txt: holds labels, but none for"):
        names.frames(labels, Path("labels.txt"))


def test_labels_of_another_folder_are_of_no_picture_here(tmp_path):
    names = PictureNames(tmp_path / "day1", ["0.png", "1.png"])
    state = CableState(1.0, 0.0, 20.0)
    labels = [Label(state, name) for name in ("day1/0.png", "day2/0.png", "day1/1.png")]
    assert names.frames(labels, tmp_path / "truth.txt") == [0, None, 1]


def test_labels_of_a_recording_of_that_name_in_another_folder_are_not_its_own(video, tmp_path):
    names = names_of(open_source(video))
    labels = [label(f"{tmp_path.name}/dive.avi", 3), label("day2/dive.avi", 4)]
    assert names.frames(labels, tmp_path.parent / "labels.txt") == [3, None]


def test_labels_of_another_recording_that_is_there_are_not_its_own(video, tmp_path):
    video.with_name("other.avi").write_bytes(b"another dive")
    names = names_of(open_source(video))
    with pytest.raises(RecordingError, match="holds labels, but none for"):
        names.frames([label("other.avi", 3)], tmp_path / "labels.txt")


def test_a_sequence_that_lists_a_frame_twice_is_refused(tmp_path):
    entries = [label("p0.png"), label("p1.png"), label("p0.png")]
    with pytest.raises(RecordingError, match=r"p0\.png 2 times"):
        EntryNames(tmp_path / "s.txt", entries)
