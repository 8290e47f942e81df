from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.particle_filter.estimates import (
    standard_deviations,
    weighted_covariance,
    weighted_mean,
)
from cable_tracker.particle_filter.weights import normalise_log_weights

STATES = np.array([[0.0, 1.0], [4.0, 1.0], [0.0, 5.0]])
WEIGHTS = np.array([0.5, 0.25, 0.25])


@st.composite
def weighted_samples(draw) -> tuple[np.ndarray, np.ndarray]:
    count, size = draw(st.integers(1, 30)), draw(st.integers(1, 6))
    states = draw(arrays(np.float64, (count, size), elements=st.floats(-1e6, 1e6)))
    logs = draw(arrays(np.float64, count, elements=st.floats(-1e5, 0.0)))
    return states, np.exp(normalise_log_weights(logs).log_weights)


def test_mean_by_hand():
    np.testing.assert_allclose(weighted_mean(STATES, WEIGHTS), [1.0, 2.0])


def test_covariance_by_hand():
    covariance = weighted_covariance(STATES, WEIGHTS, np.array([1.0, 2.0]))
    np.testing.assert_allclose(covariance, [[3.0, -1.0], [-1.0, 3.0]])


def test_covariance_about_another_point_is_the_moment_about_that_point():
    moment = weighted_covariance(STATES, WEIGHTS, np.zeros(2))
    np.testing.assert_allclose(moment, [[4.0, 1.0], [1.0, 7.0]])


def test_one_particle_has_no_covariance():
    state = np.array([[3.0, -2.0, 1e6]])
    np.testing.assert_array_equal(weighted_mean(state, np.ones(1)), state[0])
    covariance = weighted_covariance(state, np.ones(1), state[0])
    np.testing.assert_array_equal(covariance, np.zeros((3, 3)))


@given(weighted_samples())
def test_covariance_is_symmetric_and_positive_semi_definite(sample):
    covariance = weighted_covariance(*sample, weighted_mean(*sample))
    np.testing.assert_array_equal(covariance, covariance.T)
    eigenvalues = np.linalg.eigvalsh(covariance)
    assert eigenvalues.min() >= -1e-12 * max(eigenvalues.max(), 1e-300)


@given(weighted_samples())
def test_the_mean_lies_within_the_sample(sample):
    states, weights = sample
    mean = weighted_mean(states, weights)
    slack = 1e-9 * (1 + np.abs(states).max())
    assert (mean >= states.min(axis=0) - slack).all()
    assert (mean <= states.max(axis=0) + slack).all()


def test_standard_deviations_are_roots_of_the_diagonal_and_never_nan():
    covariance = np.array([[4.0, 9.0], [9.0, -1e-18]])
    np.testing.assert_array_equal(standard_deviations(covariance), [2.0, 0.0])
