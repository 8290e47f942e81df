import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scenario_states import scenario_states

from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.experiments.noise import (
    at_reference_width,
    increment_variances,
    parted_at_gaps,
    per_reference_frame,
    usual_step,
)
from cable_tracker.simulation.scenarios import SCENARIOS

THESIS_TABLE = {
    "S1": (16.92, 0.627, 0.26, 0.008),
    "S2": (2.07, 0.286, 5.19, 0.034),
    "S3": (4.92, 0.160, 0.51, 0.004),
    "S4": (4.93, 0.486, 8.59, 0.009),
    "S5": (10.21, 0.199, 0.21, 0.021),
    "S6": (10.31, 0.599, 7.50, 0.177),
}


def _states(*rows):
    return np.array(rows, dtype=float)


def test_variances_are_those_of_the_steps_in_px_and_degrees():
    radian = np.deg2rad(1.0)
    states = _states(
        (0, 0, 30, 0), (1, 2 * radian, 30, radian), (4, 2 * radian, 34, 0), (5, 6 * radian, 34, 0)
    )
    expected = [np.var(steps, ddof=1) for steps in ((1, 3, 1), (2, 0, 4), (0, 4, 0), (1, -1, 0))]
    np.testing.assert_allclose(increment_variances(states), expected)


def test_a_steady_motion_has_no_variance():
    states = np.outer(np.arange(10), (3.0, 0.01, 0.5, 0.001))
    np.testing.assert_allclose(increment_variances(states), 0.0, atol=1e-9)


@given(arrays(float, (12, 4), elements=st.floats(-1, 1)), st.floats(-20, 20))
def test_the_wrap_of_the_angle_does_not_matter(steps, start):
    states = np.zeros((13, 8))
    states[1:, :4] = np.cumsum(steps * (10, 0.2, 5, 0.02), axis=0)
    states[:, 1] += start
    straight = np.var(np.diff(states[:, :4], axis=0), axis=0, ddof=1) * (
        1, np.rad2deg(1) ** 2, 1, np.rad2deg(1) ** 2
    )  # fmt: skip
    # Writing every line with its angle in (-pi/2, pi/2] turns d and beta round within a sequence:
    # what is compared is the same sequence of lines, in the chart of each one's predecessor.
    wrapped = increment_variances(wrap_states(states))
    np.testing.assert_allclose(wrapped[[1, 2]], straight[[1, 2]], atol=1e-9)


def test_one_step_across_the_wrap_is_small():
    quarter = np.pi / 2
    states = _states(
        (10, quarter - 0.03, 30, 0.02),
        (10, quarter - 0.02, 30, 0.02),
        (10, quarter - 0.01, 30, 0.02),
        (-10, -quarter + 1e-12, 30, -0.02),
    )
    np.testing.assert_allclose(increment_variances(states), 0.0, atol=1e-9)


def test_steps_to_and_from_unlabelled_frames_do_not_count():
    gap = (np.nan,) * 4
    rows = [(0, 0, 30, 0), (1, 0, 30, 0), (3, 0, 30, 0)]
    states = _states(*rows, gap, (90, 1, 50, 0.1), gap, (5, 0, 30, 0), (6, 0, 30, 0))
    assert increment_variances(states)[0] == pytest.approx(np.var((1, 2, 1), ddof=1))


@pytest.mark.parametrize(
    "times", [[0, 1, 2, 8, 9, 10], [0, 1, 2, 1e5, 1e5 + 1, 1e5 + 2], [5, 6, 7, 0, 1, 2]]
)
def test_steps_over_gaps_and_clocks_that_jump_do_not_count(times):
    states = _states(*((place, 0, 30, 0) for place in (0, 1, 3, 90, 91, 93)))
    stamps = (np.array(times) * 40_000_000).astype(np.int64)
    parted = parted_at_gaps(states, stamps)
    assert np.flatnonzero(np.isnan(parted).any(axis=1)).tolist() == [3]
    assert increment_variances(parted)[0] == pytest.approx(np.var((1, 2, 1, 2), ddof=1))
    assert usual_step(stamps) == pytest.approx(0.04)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_frames_that_go_on_are_not_parted(count):
    states = np.zeros((count, 4))
    np.testing.assert_array_equal(parted_at_gaps(states, np.arange(count) * 10**9), states)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_too_few_labels_are_refused(count):
    with pytest.raises(ParameterError, match="consecutive labelled frames"):
        increment_variances(np.zeros((count, 4)))


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2, 3))]
)
@pytest.mark.parametrize("name", THESIS_TABLE)
def test_scenarios_have_the_variances_of_the_thesis(name, seed):
    motion = SCENARIOS[name].motion
    wanted = [sway.variance for sway in (motion.distance, motion.angle, motion.width, motion.skew)]
    np.testing.assert_array_equal(wanted, THESIS_TABLE[name])
    measured = increment_variances(scenario_states(name, seed))
    np.testing.assert_allclose(measured, wanted, rtol=0.15)


def test_lengths_of_wide_pictures_are_those_of_the_reference_width():
    states = np.array([[10.0, 0.1, 4.0, 0.2, 8.0, 0.3, 2.0, 0.4], [20.0] * 8])
    narrow = at_reference_width(states, np.array([640.0, np.nan]))
    np.testing.assert_allclose(narrow[0], [5.0, 0.1, 2.0, 0.2, 4.0, 0.3, 1.0, 0.4])
    assert np.isnan(narrow[1, [0, 2, 4, 6]]).all()
    assert states[0, 0] == 10.0


def test_variances_grow_with_the_time_between_frames_as_those_of_the_filter_do():
    np.testing.assert_allclose(per_reference_frame(np.array([2.0, 4.0]), 0.08), [1.0, 2.0])
