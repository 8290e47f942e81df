from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.particle_filter.weights import (
    effective_sample_size,
    log_sum_exp,
    masked_log_sum_exp,
    normalise_log_weights,
    uniform_log_weights,
)

ANY_LOG_WEIGHT = st.floats(-1e300, 1e300) | st.sampled_from([np.nan, np.inf, -np.inf])
ANY_LOG_WEIGHTS = arrays(np.float64, st.integers(1, 50), elements=ANY_LOG_WEIGHT)
FINITE_LOG_WEIGHTS = arrays(np.float64, st.integers(1, 50), elements=st.floats(-1e5, 1e5))


def test_log_sum_exp_of_moderate_values_is_what_it_says():
    values = np.array([0.0, 1.0, -2.0])
    assert log_sum_exp(values) == pytest.approx(np.log(np.exp(values).sum()), rel=1e-15)


@pytest.mark.parametrize("offset", [-1e5, -745.0, 0.0, 709.0, 1e5])
def test_log_sum_exp_neither_overflows_nor_underflows(offset):
    assert log_sum_exp(np.array([offset, offset])) == pytest.approx(offset + np.log(2), rel=1e-12)


def test_log_sum_exp_of_weights_that_are_all_zero_is_minus_infinity():
    assert log_sum_exp(np.full(3, -np.inf)) == -np.inf


@pytest.mark.parametrize("count", [1, 2, 3, 500])
def test_uniform_weights_sum_to_one(count):
    assert np.exp(uniform_log_weights(count)).sum() == pytest.approx(1.0, abs=1e-12)


@given(ANY_LOG_WEIGHTS)
def test_normalised_weights_always_sum_to_one(log_weights):
    result = normalise_log_weights(log_weights)
    weights = np.exp(result.log_weights)
    assert not np.isnan(weights).any()
    assert weights.sum() == pytest.approx(1.0, abs=1e-9)


@given(FINITE_LOG_WEIGHTS)
def test_normalising_keeps_the_ratios(log_weights):
    result = normalise_log_weights(log_weights)
    assert not result.degenerate
    np.testing.assert_allclose(
        np.diff(result.log_weights), np.diff(log_weights), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("value", [-np.inf, np.nan])
def test_weights_that_are_all_zero_or_nan_become_equal(value):
    result = normalise_log_weights(np.full(4, value))
    assert result.degenerate
    np.testing.assert_allclose(np.exp(result.log_weights), 0.25)


def test_nan_counts_as_zero():
    result = normalise_log_weights(np.log([0.3, np.nan, 0.1]))
    assert not result.degenerate
    np.testing.assert_allclose(np.exp(result.log_weights), [0.75, 0.0, 0.25])


def test_infinite_weights_share_everything():
    result = normalise_log_weights(np.array([np.inf, 5.0, np.inf, -np.inf, np.nan]))
    assert not result.degenerate
    np.testing.assert_allclose(np.exp(result.log_weights), [0.5, 0.0, 0.5, 0.0, 0.0])


@pytest.mark.parametrize("offset", [np.log(1e-300), -700.0, -1e5, 1e5])
def test_tiny_and_huge_weights_keep_their_ratio(offset):
    result = normalise_log_weights(offset + np.log([1.0, 3.0]))
    np.testing.assert_allclose(np.exp(result.log_weights), [0.25, 0.75], rtol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 5, 7, 14, 500, 1000])
def test_the_effective_size_of_equal_weights_is_exactly_their_number(count):
    assert effective_sample_size(uniform_log_weights(count)) == count


def test_the_effective_size_of_a_single_heavy_particle_is_one():
    assert effective_sample_size(np.array([0.0, -np.inf, -np.inf])) == 1.0


def test_the_effective_size_is_one_over_the_sum_of_squares():
    assert effective_sample_size(np.log([0.5, 0.25, 0.25])) == pytest.approx(1 / 0.375, rel=1e-12)


@given(ANY_LOG_WEIGHTS)
def test_the_effective_size_lies_between_one_and_the_number_of_particles(log_weights):
    normalised = normalise_log_weights(log_weights).log_weights
    assert 1.0 <= effective_sample_size(normalised) <= len(log_weights)


def test_a_masked_sum_is_that_of_the_rows_of_a_label():
    values, labels = np.array([0.0, 1.0, -2.0, 7.0]), np.array([3, -1, 3, 0])
    assert masked_log_sum_exp(values, labels, 3) == pytest.approx(log_sum_exp(values[[0, 2]]))
    assert masked_log_sum_exp(values, labels, 5) == -np.inf
