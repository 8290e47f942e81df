import os
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from label_strategies import label_maps

from cable_tracker.atomic_output import write_text
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import OutputError, RecordingError
from cable_tracker.gui.labelling.label_file import (
    FileContent,
    LabelFile,
    OverwriteError,
    flags_path,
    read_autosave,
    write_autosave,
)
from cable_tracker.gui.labelling.labels import WITHOUT_CABLE, FrameLabel, Origin, stamps_of
from cable_tracker.sequences.labels.frame_names import NumberedNames, PictureNames, names_of
from cable_tracker.sequences.source import open_source

from .conftest import true_state

LABELS = {
    0: FrameLabel(true_state(0), stamp=10),
    1: FrameLabel(true_state(1), Origin.INTERPOLATED),
    2: FrameLabel(true_state(2), Origin.PROPOSED),
    5: FrameLabel(None, stamp=60),
}

NAMES = NumberedNames(Path("a.avi"))
HEAD = "frame,stamp,flag,d,alpha,w,beta,file\n"
PICTURES = PictureNames(Path("dive"), [f"{number:03d}.png" for number in range(30)])


@pytest.fixture
def path(tmp_path):
    return tmp_path / "dive.avi.txt"


@pytest.fixture
def names(tmp_path):
    return NumberedNames(tmp_path / "dive.avi")


@pytest.fixture
def file(path, names):
    return LabelFile(path, names)


def read_back(path, names):
    return LabelFile(path, names).read()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(label_maps, st.sampled_from(["", "dive", "elsewhere"]), st.sampled_from(["video", "folder"]))
def test_labels_are_read_back_as_they_were_written(tmp_path, labels, below, kind):
    (tmp_path / below).mkdir(exist_ok=True)
    path = tmp_path / below / "labels.txt"
    pictures = [f"{number:03d}.png" for number in range(30)]
    names = (
        NumberedNames(tmp_path / "dive.avi")
        if kind == "video"
        else PictureNames(tmp_path / "dive", pictures)
    )
    labels = {
        frame: replace(label, stamp=40_000_000 * frame if frame % 3 else None)
        for frame, label in labels.items()
    }
    LabelFile(path, names).write(FileContent(labels), overwrite=True)
    content = read_back(path, names)
    assert content == FileContent(labels)
    assert stamps_of(content.labels) == stamps_of(labels)


def test_a_missing_file_holds_no_labels(file):
    assert file.read() == FileContent()


@pytest.mark.parametrize("kind", ["video", "bag", "folder", "sequence"])
def test_other_commands_read_the_labels_as_truth(kind, request, tmp_path):
    recording = request.getfixturevalue(kind)
    path = tmp_path / "labels.txt"
    with open_source(recording) as source:
        LabelFile(path, names_of(source)).write(
            FileContent(
                LABELS if kind != "sequence" else {frame: LABELS[frame] for frame in range(3)}
            )
        )
    with open_source(recording, truth=path) as source:
        truths = {frame.index: frame.truth for frame in source.frames()}
    assert [truths[frame] for frame in range(3)] == [LABELS[frame].state for frame in range(3)]


def test_a_label_file_beside_its_video_is_a_recording_itself(video):
    path = video.with_name("labels.txt")
    LabelFile(path, NumberedNames(video)).write(FileContent(LABELS))
    with open_source(path) as source:
        assert [frame.truth for frame in source.frames()] == [LABELS[n].state for n in range(3)]


def test_flags_name_frame_time_and_kind(file, path):
    file.write(FileContent(LABELS))
    assert flags_path(path).read_text().splitlines() == [
        "frame,stamp,flag,file",
        "0,10,hand,dive.avi:0",
        "1,,interpolated,dive.avi:1",
        "2,,proposed,dive.avi:2",
        "5,60,no_cable,dive.avi:5",
    ]


def test_labels_without_flags_were_drawn_by_hand(path, names):
    path.write_text("1 0.1 40 0 # dive.avi:3\n")
    assert read_back(path, names).labels == {3: FrameLabel(CableState(1.0, 0.1, 40.0))}


def test_where_label_and_flag_disagree_the_label_counts(file, path, names):
    file.write(FileContent({0: FrameLabel(true_state(0)), 5: WITHOUT_CABLE}))
    path.write_text("1 0.1 40 0 # dive.avi:5\n")
    assert read_back(path, names).labels == {5: FrameLabel(CableState(1.0, 0.1, 40.0))}


def test_labels_of_other_recordings_stay_in_the_file(path, names):
    path.write_text("1 0.1 40 0 # other.avi:3\n2 0.1 40 0 # dive.avi:0\n")
    flags_path(path).write_text("frame,stamp,flag,file\n3,70,interpolated,other.avi:3\n")
    file = LabelFile(path, names)
    content = file.read()
    assert set(content.labels) == {0}
    file.write(FileContent({}, content.others, content.other_flags))
    assert path.read_text().splitlines()[1:] == ["1.0 0.1 40.0 0.0 # other.avi:3"]
    assert "3,70,interpolated,other.avi:3" in flags_path(path).read_text()


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("1 0.1 40 0 # dive.avi:0\n1 0.1 40 # dive.avi:1\n", "line 2 .*3 numbers"),
        ("1 0.1 40 0 # dive.avi:0\n1 0.1 nan 0 # dive.avi:1\n", "line 2 .*not finite"),
        ("1 0.1 40 0 # ../dive.avi:0\n", "line 1 .*outside"),
    ],
)
def test_an_unreadable_label_file_is_told_by_line_and_left_alone(path, names, lines, reason):
    path.write_text(lines)
    with pytest.raises(RecordingError, match=reason):
        read_back(path, names)
    assert path.read_text() == lines


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("0,10,hand", "3 fields instead of 4"),
        ("0,10,drawn,dive.avi:0", "drawn"),
        ("0,soon,hand,dive.avi:0", "soon"),
    ],
)
def test_unreadable_flags_are_told_by_line(file, path, names, row, reason):
    file.write(FileContent(LABELS))
    flags_path(path).write_text(f"frame,stamp,flag,file\n{row}\n")
    with pytest.raises(RecordingError, match=f"flags.csv: line 2 is malformed .*{reason}"):
        read_back(path, names)


flag_pieces = st.sampled_from(
    ["frame,stamp,flag,file\n", "1,2,hand,dive.avi:1\n", "no_cable", ",", "\n", '"', "9" * 5000]
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.lists(flag_pieces | st.text(max_size=5), max_size=12))
def test_whatever_the_flags_hold_only_one_error_comes_of_it(path, names, parts):
    path.write_text("1 0.1 40 0 # dive.avi:1\n")
    flags_path(path).write_bytes("".join(parts).encode("utf-8", "surrogatepass"))
    try:
        read_back(path, names)
    except RecordingError as error:
        assert "\n" not in str(error)


def test_a_file_that_was_opened_may_be_written_again_and_again(path, names):
    LabelFile(path, names).write(FileContent(LABELS))
    file = LabelFile(path, names)
    file.read()
    file.write(FileContent({}))
    file.write(FileContent(LABELS))
    assert read_back(path, names).labels == LABELS


def test_a_file_that_was_not_opened_is_not_overwritten(path, names):
    LabelFile(path, names).write(FileContent(LABELS))
    with pytest.raises(OverwriteError, match="exists already"):
        LabelFile(path, names).write(FileContent({}))
    assert read_back(path, names).labels == LABELS


@pytest.mark.parametrize("part", ["labels", "flags"])
def test_a_file_that_has_changed_since_is_not_overwritten(file, path, part):
    file.write(FileContent(LABELS))
    changed = path if part == "labels" else flags_path(path)
    text = changed.read_text() + "\n"
    changed.write_text(text)
    with pytest.raises(OverwriteError, match="has changed on the disk"):
        file.write(FileContent({}))
    assert changed.read_text() == text


def test_a_file_that_appeared_meanwhile_is_not_overwritten(file, path):
    file.read()
    path.write_text("1 0.1 40 0 # dive.avi:3\n")
    with pytest.raises(OverwriteError):
        file.write(FileContent({}))


def test_the_user_may_overwrite_labels(file, path, names):
    path.write_text("1 0.1 40 0 # dive.avi:3\n")
    file.write(FileContent(LABELS), overwrite=True)
    assert read_back(path, names).labels == LABELS


def test_what_is_no_label_file_is_never_overwritten(video, names):
    before = video.read_bytes()
    with pytest.raises(OutputError, match="is no label file"):
        LabelFile(video, names).write(FileContent(LABELS), overwrite=True)
    assert video.read_bytes() == before


@pytest.fixture
def no_digest(monkeypatch):
    """Fail where a file is read to its end."""

    def read_whole(path):
        raise AssertionError(f"{path} was read to its end")

    monkeypatch.setattr("cable_tracker.gui.labelling.label_file.digest", read_whole)


def test_a_recording_is_refused_before_all_of_it_is_read(video, names, no_digest):
    with pytest.raises(OutputError, match="is no label file"):
        LabelFile(video, names).write(FileContent(LABELS))
    with pytest.raises(RecordingError):
        LabelFile(video, names).read()


def test_a_device_is_no_label_file(names, no_digest):
    with pytest.raises(OutputError, match="is no label file"):
        LabelFile(Path("/dev/null"), names).write(FileContent(LABELS))


def test_labels_whose_flags_could_not_be_written_can_be_saved_again(file, path, names, monkeypatch):
    def only_labels(target, text):
        if target == flags_path(path):
            raise OSError(28, "No space left on device")
        write_text(target, text)

    file.write(FileContent(LABELS))
    with monkeypatch.context() as patch:
        patch.setattr("cable_tracker.gui.labelling.label_file.write_text", only_labels)
        with pytest.raises(OutputError, match="No space left"):
            file.write(FileContent({0: LABELS[0]}))
    file.write(FileContent({0: LABELS[0]}))
    assert set(read_back(path, names).labels) == {0}


def test_a_failed_write_leaves_the_old_labels(file, path, names, monkeypatch, full_disk):
    file.write(FileContent(LABELS))
    before = path.read_bytes()

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(OutputError, match="No space left"):
        file.write(FileContent({}))
    assert path.read_bytes() == before
    assert sorted(item.name for item in path.parent.iterdir()) == [
        path.name, flags_path(path).name,
    ]  # fmt: skip


def test_a_missing_folder_is_told(tmp_path, names):
    with pytest.raises(OutputError, match="cannot be written"):
        LabelFile(tmp_path / "no" / "labels.txt", names).write(FileContent(LABELS))


def test_a_link_is_followed_and_rights_are_kept(tmp_path, names):
    target, link = tmp_path / "real.txt", tmp_path / "link.txt"
    target.write_text("")
    target.chmod(0o640)
    link.symlink_to(target)
    LabelFile(link, names).write(FileContent(LABELS), overwrite=True)
    assert link.is_symlink()
    assert "dive.avi:0" in target.read_text()
    assert target.stat().st_mode & 0o777 == 0o640


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(label_maps, st.sampled_from([NAMES, PICTURES]))
def test_unsaved_labels_are_read_back_as_they_were(tmp_path, labels, names):
    path = tmp_path / "dive.txt.autosave"
    labels = {
        frame: replace(label, stamp=40_000_000 * frame if frame % 2 else None)
        for frame, label in labels.items()
    }
    write_autosave(path, labels, names)
    read = read_autosave(path, names)
    assert read == labels
    assert stamps_of(read) == stamps_of(labels)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "line 1"),
        ("frame,d\n", "line 1"),
        (f"{HEAD}1,,hand,1,2\n", "line 2"),
        (
            "frame,stamp,flag,d,alpha,w,beta,file\n1,,hand,1,0,nan,0,a.avi:1\n",
            "line 2 .*not finite",
        ),
        (f"{HEAD}1,,no_cable,,,,,b.png\n", "not of this recording"),
        (
            "frame,stamp,flag,d,alpha,w,beta,file\n1,,no_cable,,,,,a.avi:1\n2,x,hand,1,0,3,0,a.avi:2\n",
            "line 3",
        ),
    ],
)
def test_a_damaged_file_is_told_by_line(tmp_path, text, reason):
    path = tmp_path / "dive.txt.autosave"
    path.write_text(text)
    with pytest.raises(RecordingError, match=reason):
        read_autosave(path, NAMES)


def test_labels_stay_with_their_pictures_when_some_came_or_went(tmp_path):
    path = tmp_path / "dive.txt.autosave"
    labels = {2: WITHOUT_CABLE, 3: WITHOUT_CABLE, 4: FrameLabel(None, stamp=70)}
    write_autosave(path, labels, PICTURES)
    changed = PictureNames(Path("dive"), ["000a.png", "001.png", "003.png", "004.png"])
    read = read_autosave(path, changed)
    assert read == {2: WITHOUT_CABLE, 3: WITHOUT_CABLE}
    assert stamps_of(read) == {3: 70}


pieces = st.sampled_from(
    [
        HEAD,
        "1,2,hand,3,0,5,0,a.avi:1\n",
        "no_cable",
        ",",
        "\n",
        '"',
        "9" * 5000,
    ]
)


@settings(
    max_examples=25,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.lists(pieces | st.text(max_size=5), max_size=12))
def test_whatever_a_file_holds_only_one_error_comes_of_it(tmp_path, parts):
    path = tmp_path / "dive.txt.autosave"
    path.write_bytes("".join(parts).encode("utf-8", "surrogatepass"))
    try:
        read_autosave(path, NAMES)
    except RecordingError as error:
        assert "\n" not in str(error)
