"""Numbers at their limits: whatever the weights, what comes out is finite and in order."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.particle_filter.existence import (
    PredictedExistence,
    predict_existence,
    update_existence,
)
from cable_tracker.particle_filter.particles import (
    RESAMPLING_SCHEMES,
    Particles,
    effective_sample_size,
    log_sum_exp,
    normalise_log_weights,
    weighted_covariance,
    weighted_mean,
)

counts = st.integers(1, 40)
any_log_weight = st.floats(allow_nan=True, allow_infinity=True) | st.sampled_from(
    [-math.inf, math.inf, math.log(1e-300), 0.0, 700.0, -1e308, 1e308]
)
probabilities = st.floats(0.0, 1.0)
states = counts.flatmap(lambda n: arrays(np.float64, (n, 8), elements=st.floats(-1e6, 1e6)))


def log_weights(count: int) -> st.SearchStrategy[np.ndarray]:
    return arrays(np.float64, (count,), elements=any_log_weight)


weight_vectors = counts.flatmap(log_weights)
SPECIAL = {
    "all zero": [-math.inf] * 5,
    "one has all": [-math.inf, 0.0, -math.inf],
    "one has nearly all": [0.0, math.log(1e-300), math.log(1e-300)],
    "all tiny": [math.log(1e-300)] * 7,
    "not numbers": [math.nan] * 3,
    "one not a number": [math.nan, -1.0],
    "infinite": [math.inf, 0.0, math.inf],
    "far apart": [-1e308, 1e308],
    "a single one": [-1e308],
}


def check_normalised(weights: np.ndarray) -> None:
    assert not np.isnan(weights).any()
    assert np.exp(weights).sum() == pytest.approx(1.0)
    assert 1.0 <= effective_sample_size(weights) <= len(weights)


@pytest.mark.parametrize("weights", SPECIAL.values(), ids=SPECIAL)
def test_special_weights_are_normalised(weights):
    check_normalised(normalise_log_weights(np.array(weights)).log_weights)


@given(weight_vectors)
def test_any_weights_are_normalised(weights):
    check_normalised(normalise_log_weights(weights).log_weights)


@given(counts.flatmap(lambda n: arrays(np.float64, (n,), elements=st.floats(max_value=1e300))))
def test_a_sum_of_weights_is_never_no_number(weights):
    assert not math.isnan(log_sum_exp(weights))


@pytest.mark.parametrize("scheme", RESAMPLING_SCHEMES.values(), ids=RESAMPLING_SCHEMES)
@given(weights=weight_vectors, wanted=st.integers(1, 60), seed=st.integers(0, 99))
def test_any_weights_can_be_resampled(scheme, weights, wanted, seed):
    normalised = normalise_log_weights(weights).log_weights
    drawn = scheme(np.exp(normalised), wanted, np.random.default_rng(seed))
    assert drawn.shape == (wanted,)
    assert ((drawn >= 0) & (drawn < len(weights))).all()
    assert (np.exp(normalised)[drawn] > 0.0).all()


@given(weight_vectors, st.data())
def test_any_likelihoods_keep_the_weights_normalised(weights, data):
    particles = Particles(np.zeros((len(weights), 2)), normalise_log_weights(weights).log_weights)
    posterior = particles.reweighted(data.draw(log_weights(len(weights))))
    check_normalised(posterior.log_weights)


@given(states, st.data())
@settings(max_examples=60)
def test_a_covariance_is_finite_symmetric_and_positive(sample, data):
    weights = np.exp(normalise_log_weights(data.draw(log_weights(len(sample)))).log_weights)
    mean = weighted_mean(sample, weights)
    covariance = weighted_covariance(sample, weights, mean)
    assert np.isfinite(mean).all()
    assert np.isfinite(covariance).all()
    assert (covariance == covariance.T).all()
    eigenvalues = np.linalg.eigvalsh(covariance)
    assert eigenvalues.min() >= -1e-9 * max(eigenvalues.max(), 1.0)


@given(
    probabilities,
    probabilities,
    probabilities,
    st.floats(allow_nan=False, allow_infinity=True),
    st.floats(1e-9, 0.4),
)
def test_an_existence_stays_between_its_limits(before, survival, birth, evidence, least):
    predicted = predict_existence(before, survival, birth)
    assert isinstance(predicted, PredictedExistence)
    assert least <= update_existence(predicted, evidence, least, 1.0 - least) <= 1.0 - least
