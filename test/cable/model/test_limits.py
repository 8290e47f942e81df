from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.limits import (
    LEAST_EXTENT,
    clip_to_limits,
    describe_limit_violations,
    possible_limits,
    state_limits,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters


def test_the_limits_of_particles_are_the_possible_limits():
    for limits, possible in zip(
        state_limits(TrackerParameters(), 640),
        possible_limits(TrackerParameters(), 640),
        strict=True,
    ):
        assert np.array_equal(limits, possible)


@pytest.mark.parametrize("width", [1.0, 30.0])
def test_limits_that_leave_one_value_leave_a_little_about_it_possible(width):
    parameters = TrackerParameters(width_minimum=width, width_maximum=width, skew_limit=0.0)
    lower, upper = (limit[2:] for limit in possible_limits(parameters, 320))
    np.testing.assert_allclose(upper - lower, LEAST_EXTENT[2:])
    np.testing.assert_allclose(0.5 * (lower + upper), [width, 0.0])
    assert lower[0] > 0.0


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        ([0.0, 3.0, 300.0, 0.0], ""),
        ([np.nan, 0.0, np.nan, np.nan], ""),
        ([-900.0, 0.0, 600.0, 0.0], "d -900.0 px by distance_limit, w 600.0 px by width_maximum"),
        ([0.0, 0.0, 1.0, -0.6], "w 1.0 px by width_minimum, beta -0.600 rad by skew_limit"),
    ],
)
def test_violated_limits_are_named_with_their_parameters(pose, words):
    limits = state_limits(TrackerParameters(), 640)
    assert describe_limit_violations(np.array(pose), limits) == words


def test_clipping_stops_at_the_limit():
    parameters = TrackerParameters(
        distance_limit=220.0, width_minimum=4.0, width_maximum=160.0, skew_limit=20.0
    )
    box = state_limits(parameters, 320)
    states = np.array([[223.0, 0.0, 1.0, -1.0, 50.0, 0.1, 2.0, 0.1]])
    expected = [[220.0, 0.0, 4.0, -np.deg2rad(20.0), 50.0, 0.1, 2.0, 0.1]]
    np.testing.assert_allclose(clip_to_limits(states, box), expected)
