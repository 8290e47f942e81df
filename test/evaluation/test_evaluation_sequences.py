import math

import cv2
import numpy as np
import pytest

from cable_tracker.errors import ParameterError, RecordingError
from cable_tracker.evaluation.evaluation_sequences import (
    RecordingSequence,
    ScenarioSequence,
    WorldSequence,
    available_sequences,
    reported_worlds,
    simulated_sequences,
)
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.sequences.source import open_chosen
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate
from cable_tracker.simulation.scenarios import SCENARIOS
from cable_tracker.simulation.worlds.catalogue import Split, worlds_of
from cable_tracker.simulation.worlds.ground import FOLDER_VARIABLE


@pytest.fixture(scope="module")
def frames():
    return tuple(simulate(SimulationSettings(frame_count=5, image_size=(64, 48))))


@pytest.fixture
def recording(tmp_path, frames):
    """Five labelled pictures with their sequence file."""
    folder = tmp_path / "dive"
    write_sequence(folder, frames)
    return folder


@pytest.fixture
def label_file(recording):
    (path,) = recording.glob("*.txt")
    return path


@pytest.fixture
def pictures(recording):
    return next(path.parent for path in sorted(recording.rglob("*.png")))


def test_scenarios_are_found_by_name_each_once():
    assert [s.name for s in simulated_sequences(["S3", "S1", "S3"])] == ["S3", "S1"]
    assert [s.name for s in simulated_sequences([])] == list(SCENARIOS)


def test_an_unknown_scenario_is_named_with_what_there_is():
    with pytest.raises(ParameterError, match=r"'S7' is none of S1 \| S2"):
        simulated_sequences(["S7"])


def test_a_scenario_can_be_cut_short_but_not_made_longer():
    assert ScenarioSequence("S6", 3).frame_count() == 3
    assert len(list(ScenarioSequence("S6", 3).frames(0))) == 3
    assert ScenarioSequence("S6", 9999).frame_count() == SCENARIOS["S6"].frame_count


def test_frames_of_a_scenario_are_grey_and_judged():
    frame = next(ScenarioSequence("S1", 1).frames(0))
    assert frame.image.shape == (240, 320)
    assert frame.image.dtype == np.uint8
    assert frame.truth is not None
    assert 0.0 < frame.visibility <= 1.0


def test_deep_grey_levels_are_judged_as_they_were_recorded(pictures, label_file):
    for file in pictures.glob("*.png"):
        levels = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE).astype(np.uint16)
        cv2.imwrite(str(file), levels * np.uint16(2))
    seen = next(RecordingSequence(label_file).frames(0)).image
    with open_chosen(RecordingSequence(label_file)) as source:
        tracked = decode_grey(next(iter(source.frames())).image)
    assert seen.dtype == np.float32
    assert np.array_equal(seen, tracked)


def test_without_a_cable_nothing_is_visible():
    assert next(ScenarioSequence("no_cable", 1).frames(0)).visibility == 0.0


def test_every_frame_of_a_sequence_file_is_labelled(label_file):
    sequence = RecordingSequence(label_file)
    assert sequence.frame_count() == 5
    assert [frame.visibility for frame in sequence.frames(0)] == [1.0] * 5


@pytest.mark.parametrize("empty", [True, False])
def test_frames_without_a_label_are_empty_or_not_judged(pictures, label_file, tmp_path, empty):
    some = tmp_path / "some.txt"
    some.write_text("\n".join(label_file.read_text().splitlines()[:3]) + "\n")
    sequence = RecordingSequence(pictures, truth=some, unlabelled_is_empty=empty)
    assert sequence.frame_count() == 5
    visibility = [frame.visibility for frame in sequence.frames(0)]
    assert visibility[:2] == [1.0, 1.0]
    assert all(v == 0.0 if empty else math.isnan(v) for v in visibility[2:])


def test_a_recording_without_labels_says_what_to_do(pictures):
    with pytest.raises(RecordingError, match=r"no ground truth.*--truth FILE"):
        RecordingSequence(pictures).frame_count()


def test_worlds_are_chosen_by_name_or_pattern():
    names = [each.name for each in simulated_sequences(["tune_*", "S3", "tune_faint"], 7)]
    assert names[-1] == "S3"
    assert len(names) == len(set(names)) == 1 + len(worlds_of(Split.TUNE))
    assert simulated_sequences(["tune_faint"], 7)[0].frame_count() == 7


def test_without_names_no_world_is_chosen():
    assert {each.name for each in simulated_sequences([])} == set(SCENARIOS)


def test_an_unknown_world_is_refused():
    with pytest.raises(ParameterError, match="report_faint"):
        simulated_sequences(["report_nothing*"])


def test_a_world_is_judged_by_its_truth():
    frames = list(WorldSequence("tune_clear", 3).frames(0))
    assert len(frames) == 3
    assert all(frame.truth is not None and frame.visibility > 0.5 for frame in frames)


def test_worlds_that_need_photographs_are_left_out_with_words(monkeypatch, tmp_path):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "none"))
    sequences, notes = reported_worlds(7)
    assert sequences
    assert {sequence.frame_count() for sequence in sequences} == {7}
    assert not any(sequence.name.startswith("tune") for sequence in sequences)
    named = {note.removeprefix("`").partition("` is left out: ")[0] for note in notes}
    assert named == {"report_inspection", "report_inspection_hard", "report_empty"}
    assert all(FOLDER_VARIABLE in note for note in notes)


@pytest.fixture
def no_photographs(monkeypatch, tmp_path):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "none"))


@pytest.mark.usefixtures("no_photographs")
def test_a_pattern_stands_for_the_worlds_that_can_be_drawn():
    sequences, left_out = available_sequences(["report_*"], 7)
    assert "report_clear" in {sequence.name for sequence in sequences}
    assert set(left_out) == {"report_inspection", "report_inspection_hard", "report_empty"}
    assert all(FOLDER_VARIABLE in reason for reason in left_out.values())


@pytest.mark.usefixtures("no_photographs")
def test_a_world_that_is_named_is_not_left_out():
    sequences, left_out = available_sequences(["report_inspection*", "report_inspection"])
    assert [sequence.name for sequence in sequences] == ["report_inspection"]
    assert set(left_out) == {"report_inspection_hard"}
    with pytest.raises(RecordingError, match=FOLDER_VARIABLE):
        sequences[0].frame_count()


@pytest.mark.usefixtures("no_photographs")
def test_where_no_world_of_a_pattern_can_be_drawn_the_reason_is_told():
    with pytest.raises(RecordingError, match=FOLDER_VARIABLE):
        available_sequences(["report_inspection*"])


def test_labels_of_another_folder_are_passed_over(pictures):
    own = f"{pictures.name}/{next(iter(sorted(pictures.glob('*.png')))).name}"
    truth = pictures.parent / "several.txt"
    lines = [f"1 0.1 30 0 # {name}\n" for name in (own, "other/missing.png")]
    truth.write_text("".join(lines))
    assert RecordingSequence(pictures, truth=truth).frame_count() == 5
    truth.write_text("".join([*lines, f"1 0.1 30 0 # {pictures.name}/missing.png\n"]))
    with pytest.raises(RecordingError, match=r"line 3 labels .*which is no picture in"):
        RecordingSequence(pictures, truth=truth).frame_count()


def test_a_bad_frame_is_left_out_on_request_and_else_named(pictures, label_file):
    sorted(pictures.glob("*.png"))[2].write_bytes(b"no picture")
    going_on = RecordingSequence(label_file, skip_bad_frames=True)
    assert [frame.index for frame in going_on.frames(0)] == [0, 1, 3, 4]
    with pytest.raises(RecordingError, match="frame 2"):
        list(RecordingSequence(label_file).frames(0))
