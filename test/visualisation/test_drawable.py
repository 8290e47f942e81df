import math

import numpy as np
import pytest

from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.visualisation.drawable import (
    LARGEST_SIGMA,
    drawn_spread,
    heaviest_rows,
    likely_states,
    within_reach,
)

CABLE = CableState(10.0, 0.1, 20.0)


def test_a_spread_that_is_no_number_is_not_drawn():
    assert drawn_spread(np.array([math.nan, 0.1, 1.0])) is None
    assert drawn_spread([1.0, math.inf]) is None
    assert drawn_spread([2.0, 1e9, math.nan]) == (2.0, LARGEST_SIGMA)


def test_only_likely_hypotheses_with_a_place_are_drawn():
    nowhere = CableState(math.nan, 0.0, 20.0)
    assert likely_states([Hypothesis(0.6, CABLE), Hypothesis(0.3, nowhere)]) == [CABLE]
    assert likely_states([Hypothesis(0.04, CABLE)]) == []


def test_the_heaviest_particles_come_last_and_none_without_weight():
    weights = np.array([0.3, 0.0, 0.5, 0.1, 0.9])
    usable = np.array([True, True, True, True, False])
    assert heaviest_rows(weights, usable, 2).tolist() == [0, 2]
    assert heaviest_rows(weights, usable, 9).tolist() == [3, 0, 2]


def test_lines_end_far_beyond_the_picture():
    assert within_reach(np.array([[1e9, -5.0]]), (64, 48)) == pytest.approx(
        np.array([[1280.0, -5.0]])
    )
