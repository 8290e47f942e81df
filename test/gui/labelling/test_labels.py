import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from label_strategies import frame_labels, key_frame, states

from cable_tracker.cable.model.geometry import project_borders, states_in_chart, wrap_angles
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.gui.labelling.labels import (
    NO_CABLE,
    WITHOUT_CABLE,
    FrameLabel,
    Gap,
    Origin,
    filled_gap,
    flagged_label,
    gap_at,
    gaps,
    interpolated_states,
    state_from_page,
)


def distance_between(state, other):
    """How far two cables are apart in d, alpha, w, beta, as lines."""
    there = states_in_chart(other.to_array()[None], state.angle)[0]
    return np.abs(there - state.to_array())[:4]


@given(frame_labels)
def test_a_label_is_known_by_its_state_and_flag(label):
    assert flagged_label(label.state, label.flag) == label


@pytest.mark.parametrize(
    ("state", "flag"),
    [(None, "hand"), (CableState(0.0, 0.0, 9.0), NO_CABLE), (CableState(0.0, 0.0, 9.0), "guessed")],
)
def test_a_flag_that_does_not_fit_is_refused(state, flag):
    with pytest.raises(ValueError):
        flagged_label(state, flag)


@given(states)
def test_a_state_comes_back_from_the_browser_as_it_was(state):
    assert state_from_page(state.to_array()[:4].tolist()) == state


def test_a_state_from_the_browser_is_wrapped():
    assert state_from_page([10, math.pi, 40, 0.1]) == CableState(-10.0, 0.0, 40.0, -0.1)


@pytest.mark.parametrize(
    "values",
    [
        [0, 0, 40],
        [0, 0, 0.5, 0],
        [0, 0, 40, 1.0],
        [math.nan, 0, 40, 0],
        [1e9, 0, 40, 0],
        [0, math.inf, 40, 0],
        ["0", 0, 40, 0],
        [True, 0, 40, 0],
    ],
)
def test_what_cannot_be_drawn_is_refused(values):
    with pytest.raises(ParameterError):
        state_from_page(values)


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
