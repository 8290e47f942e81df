import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.compiled.statistics import BLOCK, mean_and_covariance
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.statistics import cable_mean_and_covariance

SIGMA = np.array([5.0, 0.1, 4.0, 0.03, 20.0, 0.1, 3.0, 0.1])


def both(states, weights, still=(0.0, 0.0, 0.0, 0.0)):
    mean, covariance = np.empty(8), np.empty((8, 8))
    columns = np.ascontiguousarray(states.T)
    room = np.zeros((9, BLOCK))
    mean_and_covariance(columns, weights, np.array(still), room, mean, covariance)
    return (mean, covariance), cable_mean_and_covariance(states, weights)


@given(
    distance=st.floats(-200.0, 200.0),
    angle=st.floats(-1.57, 1.57),
    spread=st.floats(0.01, 3.0),
    count=st.integers(1, 3 * BLOCK),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_same_mean_and_covariance_as_numpy(distance, angle, spread, count, seed):
    rng = np.random.default_rng(seed)
    centre = np.array([distance, angle, 40.0, 0.05, 10.0, 0.1, 2.0, 0.05])
    states = wrap_states(centre + spread * SIGMA * rng.standard_normal((count, 8)))
    weights = rng.random(count) + 1e-3
    found, expected = both(states, weights / weights.sum())
    scale = np.sqrt(np.diag(expected[1])) + 1e-6
    np.testing.assert_allclose((found[0] - expected[0]) / scale, 0.0, atol=1e-6)
    np.testing.assert_allclose((found[1] - expected[1]) / np.outer(scale, scale), 0.0, atol=1e-6)


def test_cables_on_both_sides_of_the_wrap_are_averaged_on_one():
    states = np.zeros((2, 8))
    states[:, 0], states[:, 1] = (10.0, -12.0), (np.pi / 2 - 0.01, -np.pi / 2 + 0.03)
    (mean, covariance), _ = both(states, np.array([0.5, 0.5]))
    assert abs(mean[0]) == pytest.approx(11.0)
    assert covariance[0, 0] == pytest.approx(1.0)
    assert covariance[1, 1] == pytest.approx(0.02**2)


def test_rates_that_are_still_are_left_out_and_zero(rng):
    states = SIGMA * rng.standard_normal((50, 8))
    states[:, 6:] = 0.0
    found, expected = both(states, np.full(50, 1 / 50), still=(0.0, 0.0, 1.0, 1.0))
    np.testing.assert_allclose(found[0], expected[0], atol=1e-12)
    np.testing.assert_allclose(found[1], expected[1], atol=1e-9)
