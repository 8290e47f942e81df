from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.weigh.shared_borders import (
    SHARED_ANGLE,
    SHARED_OFFSET,
    is_within_shared_border_limits,
)
from cable_tracker.cable.model.geometry import project_borders, states_from_borders
from cable_tracker.cable.model.state import CableState

STRIP = CableState(10.0, 0.3, 40.0, 0.05).to_array()


def beside(gap=0.0, turn=0.0):
    """The strip of 30 px on the right of `STRIP`, its left border so far from the other's."""
    borders = project_borders(STRIP[None])
    borders.angles[0] = borders.angles[0, 1] + turn
    borders.offsets[0] = borders.offsets[0, 1] + gap + np.array([0.0, 30.0])
    state = np.zeros(8)
    state[:4] = states_from_borders(borders)[0]
    return state


def turned_round(state):
    other = state.copy()
    other[[0, 3]] *= -1.0
    other[1] += np.pi
    return other


@pytest.mark.parametrize("write", [np.copy, turned_round], ids=["as it is", "turned round"])
def test_neighbours_have_a_border_in_common(write):
    assert is_within_shared_border_limits(write(beside()), STRIP, 1.0)


@given(gap=st.floats(0.0, 20.0), turn=st.floats(0.0, 0.3))
def test_borders_near_each_other_are_one(gap, turn):
    assume(abs(gap - SHARED_OFFSET) > 1e-6)
    assume(abs(turn - SHARED_ANGLE) > 1e-6)
    is_near = gap < SHARED_OFFSET and turn < SHARED_ANGLE
    assert is_within_shared_border_limits(beside(gap, turn), STRIP, 1.0) == is_near


def test_a_strip_elsewhere_shares_none():
    assert not is_within_shared_border_limits(beside(gap=20.0), STRIP, 1.0)
    assert not is_within_shared_border_limits(beside(turn=0.3), STRIP, 1.0)


def test_what_is_near_grows_with_the_picture():
    neighbour = beside(gap=12.0)
    assert not is_within_shared_border_limits(neighbour, STRIP, 1.0)
    assert is_within_shared_border_limits(neighbour, STRIP, 2.0)
