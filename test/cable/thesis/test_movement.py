from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.cable.model.limits import clip_to_limits, state_limits
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.thesis.movement import reflect_at_limits

STATES = arrays(np.float64, (7, 8), elements=st.floats(-1e6, 1e6))


@pytest.mark.parametrize("limit", [clip_to_limits, reflect_at_limits])
@given(states=STATES)
def test_whatever_is_limited_ends_inside(limit, states):
    box = state_limits(TrackerParameters(), 320)
    inside = limit(states, box)
    assert (inside[:, :4] >= box.lower).all()
    assert (inside[:, :4] <= box.upper).all()
    np.testing.assert_array_equal(inside[:, [1, 5, 6, 7]], states[:, [1, 5, 6, 7]])


def test_reflection_mirrors_and_turns_the_rate_of_the_distance():
    parameters = TrackerParameters(distance_limit=220.0, width_minimum=4.0, width_maximum=160.0)
    box = state_limits(parameters, 320)
    states = np.array(
        [
            [223.0, 0.0, 1.0, 0.0, 50.0, 0.1, 2.0, 0.1],
            [-221.0, 0.0, 163.0, 0.0, -50.0, 0.1, 2.0, 0.1],
        ]
    )
    np.testing.assert_allclose(
        reflect_at_limits(states, box),
        [
            [217.0, 0.0, 7.0, 0.0, -50.0, 0.1, 2.0, 0.1],
            [-219.0, 0.0, 157.0, 0.0, 50.0, 0.1, 2.0, 0.1],
        ],
    )
