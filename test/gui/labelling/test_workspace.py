import os
import time
from dataclasses import replace

import pytest

from cable_tracker.errors import OutputError, ParameterError, RecordingError
from cable_tracker.gui.labelling.label_file import (
    FileContent,
    LabelFile,
    OverwriteError,
    autosave_path,
    write_autosave,
)
from cable_tracker.gui.labelling.labels import WITHOUT_CABLE, FrameLabel, Origin
from cable_tracker.gui.labelling.workspace import Workspace, default_label_file
from cable_tracker.sequences.labels.frame_names import names_of
from cable_tracker.sequences.source import open_source

from .conftest import COUNT, true_state

LABEL = FrameLabel(true_state(0))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "labels.txt"


@pytest.fixture
def start(folder, path):
    """Return a function that starts to label the pictures."""
    return lambda: Workspace(open_source(folder), path)


@pytest.fixture
def workspace(start):
    return start()


def edit(workspace, frame=0, label=LABEL):
    workspace.notify(workspace.document.change(frame, {frame: label}))


def test_labels_go_beside_the_recording(folder, video):
    assert default_label_file(folder) == folder.with_name("dive.txt")
    assert default_label_file(video) == video.with_name("dive.avi.txt")


def test_the_labels_of_a_sequence_file_get_a_file_of_their_own(sequence):
    assert default_label_file(sequence) == sequence.with_name("sequence.txt.labels.txt")
    upper = sequence.rename(sequence.with_name("DIVE.TXT"))
    assert default_label_file(upper) == sequence.with_name("DIVE.TXT.labels.txt")


def test_they_go_here_if_nothing_can_be_written_there(folder, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert str(default_label_file(folder)) == "dive.txt"


def test_labels_of_a_sequence_file_are_there_from_the_start(sequence, path):
    workspace = Workspace(open_source(sequence), path)
    assert [label.state.distance for label in workspace.document.labels.values()] == [0.5, 1.5, 2.5]
    assert not workspace.is_changed


def test_saved_labels_are_there_again(start, path):
    first = start()
    edit(first)
    assert first.is_changed
    first.save()
    assert not first.is_changed
    assert dict(start().document.labels) == {0: LABEL}


def test_nothing_is_written_before_it_is_saved(workspace, path):
    edit(workspace)
    assert not path.exists()


def test_listeners_hear_of_edits_until_they_leave(workspace):
    heard = []
    stop = workspace.listen(heard.append)
    edit(workspace, 3)
    stop()
    edit(workspace, 4)
    assert heard == [{3: LABEL}]


def test_unsaved_labels_are_offered_after_a_crash(start):
    first = start()
    edit(first)
    first.autosave()
    second = start()
    assert second.autosaved == {0: LABEL}
    assert not second.document.labels
    second.resume()
    assert dict(second.document.labels) == {0: LABEL}
    assert second.autosaved is None
    assert second.is_changed


def test_resuming_can_be_undone(start):
    first = start()
    edit(first)
    first.autosave()
    second = start()
    second.resume()
    second.document.undo()
    assert not second.document.labels


def test_unsaved_labels_can_be_discarded(start, path):
    first = start()
    edit(first)
    first.autosave()
    start().discard()
    assert not autosave_path(path).exists()
    assert start().autosaved is None


def test_unsaved_labels_are_not_overwritten_before_the_user_has_said_what_to_do(start, path):
    first = start()
    edit(first)
    first.autosave()
    second = start()
    edit(second, 5, WITHOUT_CABLE)
    second.autosave()
    assert start().autosaved == {0: LABEL}


def test_saving_ends_the_need_for_unsaved_labels(start, path):
    workspace = start()
    edit(workspace)
    workspace.autosave()
    assert autosave_path(path).exists()
    workspace.save()
    assert not autosave_path(path).exists()


def test_another_window_without_changes_leaves_unsaved_labels(start, path):
    other = start()
    first = start()
    edit(first)
    first.autosave()
    other.autosave()
    assert autosave_path(path).exists()


def test_undoing_everything_ends_it_too(workspace, path):
    edit(workspace)
    workspace.autosave()
    workspace.document.undo()
    workspace.autosave()
    assert not autosave_path(path).exists()


def test_unsaved_labels_that_are_older_than_the_file_are_said_to_be_so(start, folder, path):
    write_autosave(autosave_path(path), {0: WITHOUT_CABLE}, names_of(open_source(folder)))
    assert "older" not in start().describe_autosaved()
    path.write_text("1 0.1 40 0 # dive/000.png\n")
    os.utime(autosave_path(path), (1, 1))
    assert start().describe_autosaved() == (
        f"1 labelled frames of {time.strftime('%Y-%m-%d %H:%M', time.localtime(1))} were found in"
        " labels.txt.autosave. They are older than labels.txt."
    )


def test_unsaved_labels_that_say_the_same_are_not_offered(start, folder, path):
    first = start()
    edit(first)
    first.save()
    write_autosave(autosave_path(path), {0: LABEL}, names_of(open_source(folder)))
    assert start().autosaved is None


def test_unsaved_labels_of_pictures_that_are_gone_keep_nothing_from_being_saved(
    start, folder, path
):
    first = start()
    edit(first, COUNT - 2)
    edit(first, COUNT - 1)
    first.autosave()
    (folder / "000.png").unlink()
    (folder / f"{COUNT - 1:03d}.png").unlink()
    second = start()
    second.resume()
    assert dict(second.document.labels) == {COUNT - 3: LABEL}
    second.save()
    assert f"{COUNT - 2:03d}.png" in path.read_text()


def test_damaged_unsaved_labels_are_told(start, path):
    autosave_path(path).write_text("what?\n")
    with pytest.raises(RecordingError, match=r"labels\.txt\.autosave: line 1"):
        start()


@pytest.fixture
def filled_disk(monkeypatch, full_disk):
    """A disk on which there is no place for unsaved labels until the patch is undone."""
    monkeypatch.setattr("cable_tracker.gui.labelling.workspace.write_autosave", full_disk)
    return monkeypatch


def test_a_full_disk_is_told_and_labelling_goes_on(workspace, filled_disk):
    edit(workspace)
    workspace.autosave()
    assert "No space left" in workspace.trouble
    filled_disk.undo()
    workspace.autosave()
    assert not workspace.trouble


def test_saving_as_moves_to_the_new_file(workspace, path, tmp_path):
    edit(workspace)
    workspace.autosave()
    workspace.save_as(tmp_path / "other.txt")
    assert workspace.path == tmp_path / "other.txt"
    assert not path.exists()
    assert not autosave_path(path).exists()
    edit(workspace, 1)
    workspace.save()


def test_saving_as_does_not_overwrite_another_file(workspace, tmp_path):
    other = tmp_path / "other.txt"
    other.write_text("1 0.1 40 0 # dive/000.png\n")
    edit(workspace)
    with pytest.raises(OverwriteError):
        workspace.save_as(other)
    assert workspace.path != other
    workspace.save_as(other, overwrite=True)
    assert workspace.path == other


def test_saving_as_asks_before_unsaved_labels_of_that_file_are_lost(start, workspace, tmp_path):
    first, second = tmp_path / "first.txt", tmp_path / "second.txt"
    workspace.save_as(first)
    edit(workspace)
    workspace.autosave()
    second.write_text("1 0.1 40 0 # dive/003.png\n")
    workspace.open(second)
    edit(workspace, 1)
    with pytest.raises(OverwriteError, match="unsaved labels of first"):
        workspace.save_as(first)
    assert autosave_path(first).exists()
    workspace.save_as(first, overwrite=True)
    assert not autosave_path(first).exists()


def test_saving_as_never_replaces_a_picture(workspace, folder):
    edit(workspace)
    with pytest.raises(OutputError, match="is no label file"):
        workspace.save_as(folder / "000.png", overwrite=True)


def test_another_label_file_can_be_opened(workspace, tmp_path):
    other = tmp_path / "other.txt"
    other.write_text("1 0.1 40 0 # dive/003.png\n")
    workspace.open(other)
    assert set(workspace.document.labels) == {3}
    assert workspace.path == other


def test_what_was_not_saved_waits_beside_its_own_file(start, workspace, tmp_path):
    other = tmp_path / "other.txt"
    other.write_text("1 0.1 40 0 # dive/003.png\n")
    edit(workspace)
    workspace.open(other)
    assert start().autosaved == {0: LABEL}


def test_labels_that_cannot_be_kept_are_not_given_up_for_another_file(
    workspace, path, tmp_path, filled_disk
):
    other = tmp_path / "other.txt"
    other.write_text("1 0.1 40 0 # dive/003.png\n")
    edit(workspace)
    with pytest.raises(OutputError, match="No space left"):
        workspace.open(other)
    assert workspace.path == path
    assert dict(workspace.document.labels) == {0: LABEL}


@pytest.mark.parametrize("lines", [None, "1 2 3 # dive/003.png\n"])
def test_a_file_that_cannot_be_opened_changes_nothing(workspace, tmp_path, path, lines):
    other = tmp_path / "other.txt"
    if lines is not None:
        other.write_text(lines)
    edit(workspace)
    with pytest.raises(RecordingError, match=r"other\.txt"):
        workspace.open(other)
    assert workspace.path == path
    assert dict(workspace.document.labels) == {0: LABEL}


MOVED = FrameLabel(true_state(9))


@pytest.fixture
def reopened(video, path):
    """Return a function that opens labels of frames 0 to 4, of which the inner are interpolated."""

    def write_and_open(stamps):
        source = open_source(video)
        between = FrameLabel(LABEL.state, Origin.INTERPOLATED)
        labels = {0: LABEL, 4: LABEL, **dict.fromkeys((1, 2, 3), between)}
        drawn = {frame: replace(label, stamp=stamps[frame]) for frame, label in labels.items()}
        LabelFile(path, names_of(source)).write(FileContent(drawn))
        return Workspace(source, path)

    return write_and_open


@pytest.fixture
def displaced(reopened):
    """Return a workspace whose labels are of another time."""
    return reopened(dict.fromkeys(range(5), 1))


def test_labels_of_other_times_are_noticed(displaced):
    assert displaced.is_displaced(displaced.picture(2))
    assert not displaced.is_displaced(displaced.picture(5))


def test_a_frame_that_is_labelled_anew_has_the_time_that_it_has_now(displaced):
    picture = displaced.picture(4)
    displaced.change(4, LABEL)
    displaced.change(2, MOVED)  # copied there before its picture has come
    assert not displaced.is_displaced(picture)
    assert displaced.missing_stamps([0, 2, 4]) == [2]
    assert not displaced.is_displaced(displaced.picture(2))
    assert displaced.missing_stamps([0, 2, 4]) == []


def test_interpolated_frames_have_new_times_with_the_frame_labelled_anew(displaced, video, path):
    displaced.picture(4)
    displaced.change(4, MOVED)
    assert displaced.missing_stamps(range(5)) == [1, 2, 3]
    displaced.read_stamps([1, 2, 3])
    displaced.save()
    again = Workspace(open_source(video), path)
    assert [again.is_displaced(again.picture(frame)) for frame in range(5)] == [True] + 4 * [False]


def test_times_in_the_file_serve_for_new_labels_where_they_are_those_of_the_recording(
    reopened, video
):
    stamps = {frame.index: frame.stamp for frame in open_source(video).frames()}
    workspace = reopened({frame: stamps[frame] for frame in range(5)})
    workspace.picture(4)
    workspace.change(4, MOVED)
    assert workspace.missing_stamps(range(6)) == [5]
    assert [workspace.stamp(frame) for frame in range(5)] == [stamps[n] for n in range(5)]


def test_a_label_that_is_drawn_as_it_was_leaves_those_beside_it_their_time(displaced):
    pictures = [displaced.picture(frame) for frame in range(5)]
    displaced.change(4, LABEL)
    assert [displaced.is_displaced(each) for each in pictures] == [True] * 4 + [False]


def test_undo_gives_a_label_back_the_time_that_stands_in_its_file(displaced):
    picture = displaced.picture(4)
    displaced.change(4, MOVED)
    assert not displaced.is_displaced(picture)
    displaced.undo()
    assert displaced.is_displaced(picture)
    displaced.redo()
    assert not displaced.is_displaced(picture)


def test_a_label_that_is_resumed_has_the_time_at_which_it_was_drawn(displaced, video, path):
    picture = displaced.picture(4)
    displaced.change(4, MOVED)
    displaced.autosave()
    again = Workspace(open_source(video), path)
    again.resume()
    assert not again.is_displaced(picture)
    assert again.missing_stamps([4]) == []


def test_only_frames_are_labelled(workspace):
    workspace.need_frame(COUNT - 1)
    for frame in (-1, COUNT):
        with pytest.raises(ParameterError):
            workspace.need_frame(frame)


def test_times_are_asked_of_frames_only(workspace):
    assert workspace.missing_stamps([0, COUNT]) == [0]


def test_pictures_tell_their_times(workspace):
    picture = workspace.picture(2)
    assert picture.size == (320, 240)
    assert workspace.stamp(2) == picture.stamp
    assert workspace.missing_stamps([1, 2, 3]) == [1, 3]
    assert workspace.read_stamps([1, 99]) is None
    assert workspace.missing_stamps([1, 2, 3]) == [3]


def test_times_behind_damage_are_read_and_the_damage_is_told(folder, start):
    (folder / "005.png").write_bytes(b"no picture")
    workspace = start()
    workspace.picture(9)
    damage = workspace.read_stamps([4, 5, 7])
    assert workspace.missing_stamps([4, 5, 7]) == [5]
    assert "005.png" in str(damage)
    assert workspace.count == COUNT
    assert workspace.picture(9).frame == 9


def test_a_picture_whose_name_is_no_utf8_is_told_before_anything_is_labelled(folder, start):
    (folder / "003.png").rename(folder / os.fsdecode(b"caf\xe9.png"))
    with pytest.raises(RecordingError, match=r"dive/caf\\xe9\.png: .* rename it, .*convmv"):
        start()


@pytest.mark.parametrize("name", [" 003.png", "a\n003.png", "a\x07.png"])
def test_a_name_that_labels_cannot_hold_is_told_before_anything_is_labelled(folder, name):
    (folder / "003.png").rename(folder / name)
    with pytest.raises(RecordingError, match=r"labels cannot name it, .*; rename it$") as caught:
        Workspace(open_source(folder), folder / "labels.txt")
    assert repr(name) in str(caught.value)


@pytest.mark.parametrize("name", [" dive", "di\nve"])
def test_a_recording_whose_name_labels_cannot_hold_is_told(folder, tmp_path, name):
    home = folder.rename(tmp_path / name)
    with pytest.raises(RecordingError, match=r"labels cannot name it, .*; rename it$"):
        Workspace(open_source(home), tmp_path / "labels.txt")


def test_a_folder_that_labels_name_must_be_utf8_and_one_that_they_do_not_name_need_not(
    folder, tmp_path
):
    home = folder.rename(tmp_path / os.fsdecode(b"dive\xe9"))
    with pytest.raises(RecordingError, match=r"dive\\xe9/000\.png: .* rename it, .*convmv"):
        Workspace(open_source(home), tmp_path / "labels.txt")
    inside = Workspace(open_source(home), home / "labels.txt")
    edit(inside)
    inside.save()
    assert not inside.trouble
