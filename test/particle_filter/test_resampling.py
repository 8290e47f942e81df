from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.particle_filter.resampling import (
    RESAMPLING_SCHEMES,
    residual_resampling,
    stratified_resampling,
    systematic_resampling,
)
from cable_tracker.particle_filter.weights import normalise_log_weights, uniform_log_weights

SCHEMES = pytest.mark.parametrize("scheme", RESAMPLING_SCHEMES.values(), ids=RESAMPLING_SCHEMES)
WEIGHTS = np.array([0.0, 0.02, 0.31, 0.005, 0.0, 0.445, 0.17, 0.05, 0.0])
REPEATS = 4000


@st.composite
def weight_vectors(draw) -> np.ndarray:
    raw = draw(
        arrays(np.float64, st.integers(1, 40), elements=st.just(0.0) | st.floats(1e-300, 1.0))
    )
    assume(raw.sum() > 0.0)
    return raw / raw.sum()


def copies(scheme, weights, count, rng) -> np.ndarray:
    return np.bincount(scheme(weights, count, rng), minlength=len(weights))


@SCHEMES
@pytest.mark.parametrize("count", [9, 14, 100])
def test_every_particle_is_drawn_as_often_as_its_weight_says(scheme, count, rng):
    drawn = np.array([copies(scheme, WEIGHTS, count, rng) for _ in range(REPEATS)])
    # No unbiased scheme varies more than independent draws: N w (1 - w). Five standard errors.
    margin = 5 * np.sqrt(count * WEIGHTS * (1 - WEIGHTS) / REPEATS)
    assert (np.abs(drawn.mean(axis=0) - count * WEIGHTS) <= margin).all()


@SCHEMES
@given(weights=weight_vectors(), count=st.integers(1, 60), seed=st.integers(0, 2**32 - 1))
def test_what_is_drawn_has_the_wanted_number_and_a_positive_weight(scheme, weights, count, seed):
    indices = scheme(weights, count, np.random.default_rng(seed))
    assert indices.shape == (count,)
    assert indices.dtype == np.int64
    assert (weights[indices] > 0.0).all()


@SCHEMES
@pytest.mark.parametrize("position", [0.0, np.nextafter(1.0, 0.0)])
def test_the_ends_of_the_random_numbers_draw_no_particle_of_weight_zero(scheme, position):
    class Fixed:
        def random(self, size=None):
            return position if size is None else np.full(size, position)

    weights = np.array([0.0, 0.1, 0.2, 0.3, 0.1, 0.1, 0.1, 0.1, 0.0, 0.0])
    assert (weights[scheme(weights, 7, Fixed())] > 0.0).all()


@given(weights=weight_vectors(), count=st.integers(1, 60), seed=st.integers(0, 2**32 - 1))
def test_systematic_copies_differ_from_the_expected_by_less_than_one(weights, count, seed):
    drawn = copies(systematic_resampling, weights, count, np.random.default_rng(seed))
    assert (np.abs(drawn - count * weights) < 1.0 + 1e-9).all()


@given(weights=weight_vectors(), count=st.integers(1, 60), seed=st.integers(0, 2**32 - 1))
def test_stratified_copies_differ_from_the_expected_by_less_than_two(weights, count, seed):
    drawn = copies(stratified_resampling, weights, count, np.random.default_rng(seed))
    assert (np.abs(drawn - count * weights) < 2.0 + 1e-9).all()


@given(weights=weight_vectors(), count=st.integers(1, 60), seed=st.integers(0, 2**32 - 1))
def test_residual_copies_are_at_least_the_whole_part_of_the_expected(weights, count, seed):
    drawn = copies(residual_resampling, weights, count, np.random.default_rng(seed))
    assert (drawn >= np.floor(count * weights)).all()


@pytest.mark.parametrize("scheme", [systematic_resampling, residual_resampling])
@pytest.mark.parametrize("count", [1, 2, 9, 10, 500, 997])
def test_equal_weights_draw_every_particle_once(scheme, count, rng):
    weights = np.exp(uniform_log_weights(count))
    assert sorted(scheme(weights, count, rng)) == list(range(count))


@SCHEMES
def test_one_particle_is_drawn_every_time(scheme, rng):
    assert scheme(np.array([1.0]), 5, rng).tolist() == [0] * 5


@SCHEMES
@pytest.mark.parametrize("offset", [np.log(1e-300), -700.0, -1e5])
def test_weights_that_were_tiny_before_they_were_normalised(scheme, offset, rng):
    weights = np.exp(normalise_log_weights(offset + np.log([1.0, 1e-300, 1.0])).log_weights)
    assert set(scheme(weights, 50, rng)) == {0, 2}


def test_the_other_schemes_add_less_variance_than_independent_draws(rng):
    def spread(name: str) -> float:
        drawn = [copies(RESAMPLING_SCHEMES[name], WEIGHTS, 50, rng) for _ in range(500)]
        return float(np.var(drawn, axis=0).sum())

    multinomial = spread("multinomial")
    assert max(spread(name) for name in ("stratified", "systematic", "residual")) < multinomial / 2
