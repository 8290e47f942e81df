from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.particle_filter import weights as plain

pytest.importorskip("numba")

from cable_tracker.particle_filter.compiled.weights import (
    effective_sample_size,
    log_sum_exp,
    normalise,
    normalised,
)

FINITE = arrays(np.float64, st.integers(1, 60), elements=st.floats(-1e4, 1e4))
POSSIBLE = arrays(
    np.float64,
    st.integers(1, 60),
    elements=st.one_of(st.floats(-1e4, 1e4), st.just(-math.inf)),
)
ANY = arrays(
    np.float64,
    st.integers(1, 60),
    elements=st.one_of(st.floats(-1e300, 1e300), st.sampled_from([-math.inf, math.inf, math.nan])),
)


@given(POSSIBLE)
def test_sums_are_the_same(values):
    assert log_sum_exp(values) == pytest.approx(plain.log_sum_exp(values), rel=1e-12)


@given(ANY)
def test_normalised_weights_are_the_same_whatever_they_were(values):
    expected = plain.normalise_log_weights(values)
    result, degenerate = normalised(values)
    assert degenerate == expected.degenerate
    np.testing.assert_allclose(result, expected.log_weights, rtol=1e-12, atol=1e-12)
    assert np.exp(result).sum() == pytest.approx(1.0)


def test_normalising_changes_nothing_in_place():
    values = np.array([0.0, -1.0, math.nan])
    normalised(values)
    np.testing.assert_array_equal(values, [0.0, -1.0, math.nan])


@given(FINITE)
def test_effective_sample_sizes_are_the_same(values):
    assert effective_sample_size(values) == pytest.approx(
        plain.effective_sample_size(values), rel=1e-12
    )


@given(st.integers(1, 500))
def test_one_that_weighs_all_counts_as_one_and_equal_ones_as_all(count):
    one = np.where(np.arange(count) == count // 2, 0.0, -math.inf)
    assert effective_sample_size(one) == 1.0
    assert effective_sample_size(plain.uniform_log_weights(count)) == count


@given(arrays(np.float64, st.integers(1, 60), elements=st.floats(1e-100, 1e100)))
def test_the_same_weights_as_numpy(weights):
    expected = plain.normalise_log_weights(np.log(weights)).log_weights
    found = weights.copy()
    size = normalise(found)
    np.testing.assert_allclose(found, np.exp(expected), rtol=1e-9, atol=1e-200)
    assert size == pytest.approx(plain.effective_sample_size(expected))


@pytest.mark.parametrize("count", [1, 3, 500, 997])
def test_equal_weights_are_worth_exactly_as_many(count):
    assert normalise(np.full(count, 0.1)) == count


def test_no_weight_becomes_zero():
    weights = np.array([1e300, 1e-300])
    normalise(weights)
    assert (weights > 0.0).all()
