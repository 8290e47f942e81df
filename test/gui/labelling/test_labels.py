import math

import pytest
from hypothesis import given
from label_strategies import frame_labels, states

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.gui.labelling.labels import (
    NO_CABLE,
    flagged_label,
    state_from_page,
)


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
