import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from label_strategies import frame_labels, key_frame, label_maps, states

from cable_tracker.cable.model.geometry import project_borders, states_in_chart, wrap_angles
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.gui.labelling.document import (
    Gap,
    LabelDocument,
    filled_gap,
    gap_at,
    gaps,
    interpolated_states,
)
from cable_tracker.gui.labelling.labels import WITHOUT_CABLE, FrameLabel, Origin

frames = st.integers(0, 29)
hand_labels = frame_labels.filter(lambda label: label.is_key)


def document_of(labels):
    """Return a document whose frames have no times."""
    return LabelDocument(labels, {})


def distances(document):
    return {frame: label.state.distance for frame, label in sorted(document.labels.items())}


@given(label_maps, frames, frame_labels)
def test_undo_takes_an_edit_back_and_redo_does_it_again(labels, frame, label):
    document = document_of(labels)
    document.change(frame, {frame: label})
    edited = dict(document.labels)
    if document.can_undo:
        assert document.undo()[0] == frame
    assert dict(document.labels) == labels
    if document.can_redo:
        assert document.redo()[0] == frame
    assert dict(document.labels) == edited


@given(label_maps, frames, frame_labels)
def test_what_an_edit_returns_is_what_has_changed(labels, frame, label):
    document = document_of(labels)
    changes = document.change(frame, {frame: label})
    after = document.labels
    different = {n for n in {*labels, *after} if labels.get(n) != after.get(n)}
    assert changes == {n: after.get(n) for n in different}


def test_nothing_to_undo_in_a_new_document():
    document = document_of({0: key_frame()})
    assert document.undo() is None
    assert document.redo() is None


def test_an_edit_that_changes_nothing_is_no_step():
    document = document_of({3: key_frame()})
    assert document.change(3, {3: key_frame()}) == {}
    assert not document.can_undo


def test_a_new_edit_forgets_what_was_undone():
    document = document_of({})
    document.change(0, {0: key_frame(1.0)})
    document.undo()
    document.change(0, {0: key_frame(2.0)})
    assert not document.can_redo


def test_strokes_of_a_held_key_are_one_step():
    document = document_of({4: key_frame(0.0)})
    document.change(4, {4: key_frame(1.0)})
    document.change(4, {4: key_frame(2.0)}, merges=True)
    document.change(4, {4: key_frame(3.0)}, merges=True)
    document.undo()
    assert distances(document) == {4: 0.0}


def test_strokes_on_another_frame_are_another_step():
    document = document_of({4: key_frame(0.0), 5: key_frame(0.0)})
    document.change(4, {4: key_frame(1.0)})
    document.change(5, {5: key_frame(2.0)}, merges=True)
    document.undo()
    assert distances(document) == {4: 1.0, 5: 0.0}


def test_interpolation_fills_the_gap_at_a_frame():
    document = document_of({0: key_frame(0.0), 4: key_frame(40.0), 6: key_frame(60.0)})
    document.interpolate(2, document.gaps_to_fill(2))
    assert distances(document) == pytest.approx(
        {0: 0.0, 1: 10.0, 2: 20.0, 3: 30.0, 4: 40.0, 6: 60.0}
    )


def test_interpolation_fills_all_gaps():
    document = document_of({0: key_frame(0.0), 2: key_frame(20.0), 4: key_frame(40.0)})
    document.interpolate(0, document.gaps_to_fill(None))
    assert distances(document) == pytest.approx({0: 0.0, 1: 10.0, 2: 20.0, 3: 30.0, 4: 40.0})


def test_where_nothing_can_be_interpolated_it_is_said():
    with pytest.raises(ParameterError, match="nothing to interpolate"):
        document_of({0: key_frame(), 5: WITHOUT_CABLE, 9: key_frame()}).gaps_to_fill(3)


def test_interpolated_labels_follow_their_key_frame_in_the_same_step():
    document = document_of({0: key_frame(0.0), 4: key_frame(40.0)})
    document.interpolate(0, document.gaps_to_fill(0))
    document.change(4, {4: key_frame(80.0)})
    assert distances(document) == pytest.approx({0: 0.0, 1: 20.0, 2: 40.0, 3: 60.0, 4: 80.0})
    document.undo()
    assert distances(document) == pytest.approx({0: 0.0, 1: 10.0, 2: 20.0, 3: 30.0, 4: 40.0})


def test_a_corrected_frame_becomes_a_key_frame_of_its_neighbours():
    document = document_of({0: key_frame(0.0), 4: key_frame(40.0)})
    document.interpolate(0, document.gaps_to_fill(0))
    document.change(2, {2: key_frame(100.0)})
    assert distances(document) == pytest.approx({0: 0.0, 1: 50.0, 2: 100.0, 3: 70.0, 4: 40.0})


def filled_document():
    document = document_of({0: key_frame(0.0), 6: key_frame(60.0)})
    document.interpolate(0, document.gaps_to_fill(0))
    return document


def test_nothing_stays_interpolated_across_a_frame_without_cable():
    document = filled_document()
    changes = document.change(3, {3: WITHOUT_CABLE})
    assert changes == {3: WITHOUT_CABLE, 1: None, 2: None, 4: None, 5: None}
    assert sorted(document.labels) == [0, 3, 6]
    document.undo()
    assert sorted(document.labels) == list(range(7))


@pytest.mark.parametrize("taken", [0, 6])
def test_interpolated_labels_go_with_the_key_frame_that_ends_them(taken):
    document = filled_document()
    document.change(taken, {taken: None})
    assert sorted(document.labels) == [6 - taken]
    document.undo()
    assert sorted(document.labels) == list(range(7))


def test_each_gap_is_filled_once_and_an_edit_fills_only_those_beside_it(monkeypatch):
    filled = []

    def noted(labels, gap, times):
        filled.append(gap)
        return filled_gap(labels, gap, times)

    monkeypatch.setattr("cable_tracker.gui.labelling.document.filled_gap", noted)
    document = document_of({frame: key_frame() for frame in range(0, 1001, 10)})
    document.interpolate(0, document.gaps_to_fill(None))
    assert len(filled) == 100
    filled.clear()
    document.change(500, {500: key_frame(1.0)})
    assert [frame for gap in filled for frame in gap.frames] == [*range(491, 500), *range(501, 510)]


def test_interpolated_labels_elsewhere_stay_as_the_file_has_them():
    left = FrameLabel(CableState(1.0, 0.1, 40.0), Origin.INTERPOLATED)
    document = document_of({0: key_frame(), 2: left, 5: WITHOUT_CABLE, 9: key_frame()})
    document.change(9, {9: key_frame(1.0)})
    assert document.labels[2] == left


def test_replacing_all_labels_can_be_undone():
    document = document_of({0: key_frame(1.0), 1: key_frame(2.0)})
    document.replace({1: key_frame(3.0), 2: key_frame(4.0)})
    assert distances(document) == {1: 3.0, 2: 4.0}
    document.undo()
    assert distances(document) == {0: 1.0, 1: 2.0}


class Editing(RuleBasedStateMachine):
    """Whatever is done, undo goes back through it, and interpolated labels fit their key frames."""

    def __init__(self):
        super().__init__()
        self.document = document_of({})
        self.history = [{}]

    def remember(self, changes):
        if changes:
            self.history.append(dict(self.document.labels))

    @rule(frame=frames, label=hand_labels)
    def draw(self, frame, label):
        self.remember(self.document.change(frame, {frame: label}))

    @rule(frame=frames)
    def clear(self, frame):
        self.remember(self.document.change(frame, {frame: None}))

    @rule()
    def interpolate_all(self):
        wanted = gaps(self.document.labels)
        self.remember(self.document.interpolate(0, wanted))

    @rule()
    def undo(self):
        assert (self.document.undo() is None) == (len(self.history) == 1)
        if len(self.history) > 1:
            self.history.pop()

    @invariant()
    def labels_are_those_of_the_history(self):
        assert dict(self.document.labels) == self.history[-1]

    @invariant()
    def interpolated_labels_fit_their_key_frames(self):
        labels = self.document.labels
        between = {frame for gap in gaps(labels) for frame in gap.frames}
        assert all(label.is_key or frame in between for frame, label in labels.items())
        for gap in gaps(labels):
            filled = filled_gap(labels, gap, {})
            for frame in gap.frames:
                assert labels.get(frame) in (None, filled[frame])


TestEditing = Editing.TestCase


def distance_between(state, other):
    """How far two cables are apart in d, alpha, w, beta, as lines."""
    there = states_in_chart(other.to_array()[None], state.angle)[0]
    return np.abs(there - state.to_array())[:4]


@given(states, states)
def test_interpolation_begins_and_ends_at_the_key_frames(before, after):
    assert distance_between(before, interpolated_states(before, after, [0.0])[0]) == pytest.approx(
        np.zeros(4), abs=1e-6
    )
    assume(abs(math.cos(after.angle - before.angle)) > 1e-6)
    assert distance_between(after, interpolated_states(before, after, [1.0])[0]) == pytest.approx(
        np.zeros(4), abs=1e-6
    )


@given(states, states, st.floats(0.0, 1.0))
def test_interpolation_takes_the_short_way_round(before, after, fraction):
    between = interpolated_states(before, after, [fraction])[0]
    whole = abs(float(wrap_angles(np.array(after.angle - before.angle))))
    part = abs(float(wrap_angles(np.array(between.angle - before.angle))))
    assert part <= whole + 1e-9
    assert -math.pi / 2 < between.angle <= math.pi / 2
    assert between.width > 0.0


def test_interpolation_across_the_wrap_does_not_turn_the_cable_round():
    almost, beyond = math.radians(88.0), math.radians(-88.0)
    (between,) = interpolated_states(
        CableState(20.0, almost, 40.0, 0.1), CableState(-20.0, beyond, 40.0, -0.1), [0.5]
    )
    assert distance_between(CableState(20.0, math.pi / 2, 40.0, 0.1), between) == pytest.approx(
        np.zeros(4), abs=1e-9
    )


def test_each_border_moves_evenly():
    before, after = CableState(-30.0, 0.2, 40.0, 0.05), CableState(50.0, -0.1, 60.0, 0.15)
    both = project_borders(np.stack((before.to_array(), after.to_array())))
    quarter = project_borders(interpolated_states(before, after, [0.25])[0].to_array()[None])
    assert quarter.angles[0] == pytest.approx(0.75 * both.angles[0] + 0.25 * both.angles[1])
    assert quarter.offsets[0] == pytest.approx(0.75 * both.offsets[0] + 0.25 * both.offsets[1])


def test_gaps_lie_between_key_frames_with_a_cable():
    labels = {
        0: key_frame(),
        1: key_frame(),
        5: key_frame(),
        8: WITHOUT_CABLE,
        12: key_frame(),
        20: key_frame(),
    }
    assert gaps(labels) == [Gap(1, 5), Gap(12, 20)]


def test_interpolated_frames_are_no_key_frames():
    labels = {0: key_frame(), 3: FrameLabel(key_frame().state, Origin.INTERPOLATED), 6: key_frame()}
    assert gaps(labels) == [Gap(0, 6)]


@pytest.mark.parametrize(
    ("frame", "gap"), [(0, Gap(0, 5)), (3, Gap(0, 5)), (5, Gap(0, 5)), (8, Gap(5, 9)), (10, None)]
)
def test_the_gap_at_a_frame_lies_between_the_key_frames_around_it(frame, gap):
    assert gap_at({0: key_frame(), 5: key_frame(), 9: key_frame()}, frame) == gap


def test_a_gap_is_filled_over_time_not_over_numbers():
    labels = {0: key_frame(0.0), 3: key_frame(90.0)}
    filled = filled_gap(labels, Gap(0, 3), {0: 0, 1: 10, 2: 20, 3: 90})
    assert {frame: label.state.distance for frame, label in filled.items()} == pytest.approx(
        {1: 10.0, 2: 20.0}
    )
    assert {label.origin for label in filled.values()} == {Origin.INTERPOLATED}


@pytest.mark.parametrize("stamps", [{}, {0: 0, 1: 10, 3: 90}, {0: 5, 1: 5, 2: 5, 3: 5}])
def test_without_usable_times_the_frames_are_equally_far_apart(stamps):
    filled = filled_gap({0: key_frame(0.0), 3: key_frame(90.0)}, Gap(0, 3), stamps)
    assert [label.state.distance for label in filled.values()] == pytest.approx([30.0, 60.0])
