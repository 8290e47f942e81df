from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.particle_filter.particles import (
    RESAMPLING_SCHEMES,
    Particles,
    effective_sample_size,
    log_sum_exp,
    masked_log_sum_exp,
    normalise_log_weights,
    residual_resampling,
    standard_deviations,
    stratified_resampling,
    systematic_resampling,
    uniform_log_weights,
    weighted_covariance,
    weighted_mean,
)

ANY_LOG_WEIGHT = st.floats(-1e300, 1e300) | st.sampled_from([np.nan, np.inf, -np.inf])
ANY_LOG_WEIGHTS = arrays(np.float64, st.integers(1, 50), elements=ANY_LOG_WEIGHT)
FINITE_LOG_WEIGHTS = arrays(np.float64, st.integers(1, 50), elements=st.floats(-1e5, 1e5))

SCHEMES = pytest.mark.parametrize("scheme", RESAMPLING_SCHEMES.values(), ids=RESAMPLING_SCHEMES)
WEIGHTS = np.array([0.0, 0.02, 0.31, 0.005, 0.0, 0.445, 0.17, 0.05, 0.0])
REPEATS = 4000

STATES = np.array([[0.0, 1.0], [4.0, 1.0], [0.0, 5.0]])
STATE_WEIGHTS = np.array([0.5, 0.25, 0.25])


@pytest.fixture
def particles() -> Particles:
    return Particles(np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]), np.log([0.5, 0.3, 0.2]))


def test_weights_of_equally_weighted_particles_are_equal_and_sum_to_one():
    particles = Particles.equally_weighted(np.zeros((4, 2)))
    assert particles.count == 4
    np.testing.assert_allclose(particles.weights, 0.25)


@pytest.mark.parametrize(
    ("states", "log_weights"),
    [
        (np.zeros((0, 2)), np.zeros(0)),
        (np.zeros(3), np.zeros(3)),
        (np.zeros((3, 2)), np.zeros(2)),
        (np.zeros((3, 2)), np.zeros((3, 1))),
    ],
)
def test_shapes_that_do_not_belong_together_are_refused(states, log_weights):
    with pytest.raises(ValueError, match="shape"):
        Particles(states, log_weights)


def test_moving_keeps_the_weights(particles):
    moved = particles.moved_to(particles.states + 1.0)
    np.testing.assert_array_equal(moved.weights, particles.weights)
    np.testing.assert_array_equal(moved.states, particles.states + 1.0)


def test_likelihoods_multiply_the_weights(particles):
    posterior = particles.reweighted(np.log([0.1, 0.2, 0.4]))
    np.testing.assert_allclose(posterior.weights, np.array([0.05, 0.06, 0.08]) / 0.19)


@pytest.mark.parametrize("value", [-np.inf, np.nan])
def test_an_observation_that_excludes_everything_changes_nothing(particles, value):
    assert particles.reweighted(np.full(3, value)) is particles


def test_particles_of_nan_likelihood_drop_out(particles):
    posterior = particles.reweighted(np.array([0.0, np.nan, 0.0]))
    np.testing.assert_allclose(posterior.weights, [5 / 7, 0.0, 2 / 7])


def test_a_weight_of_zero_times_an_infinite_likelihood_is_zero():
    particles = Particles(np.zeros((3, 1)), np.array([-np.inf, np.log(0.5), np.log(0.5)]))
    posterior = particles.reweighted(np.array([np.inf, 0.0, np.log(3.0)]))
    np.testing.assert_allclose(posterior.weights, [0.0, 0.25, 0.75])


def test_likelihoods_of_another_number_of_particles_are_refused(particles):
    with pytest.raises(ValueError, match="shape"):
        particles.reweighted(np.zeros((3, 1)))


def test_selected_particles_weigh_the_same(particles):
    selected = particles.selected(np.array([2, 2, 0, 1]))
    np.testing.assert_array_equal(selected.states[:, 0], [5.0, 5.0, 1.0, 3.0])
    np.testing.assert_allclose(selected.weights, 0.25)


def test_log_sum_exp_of_moderate_values_is_the_logarithm_of_the_sum():
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
def test_every_particle_is_drawn_in_proportion_to_its_weight(scheme, count, rng):
    drawn = np.array([copies(scheme, WEIGHTS, count, rng) for _ in range(REPEATS)])
    # No unbiased scheme varies more than independent draws: N w (1 - w). Five standard errors.
    margin = 5 * np.sqrt(count * WEIGHTS * (1 - WEIGHTS) / REPEATS)
    assert (np.abs(drawn.mean(axis=0) - count * WEIGHTS) <= margin).all()


@SCHEMES
@given(weights=weight_vectors(), count=st.integers(1, 60), seed=st.integers(0, 2**32 - 1))
def test_resampling_draws_as_many_as_wanted_of_positive_weight(scheme, weights, count, seed):
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
def test_a_single_particle_is_drawn_every_time(scheme, rng):
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


@st.composite
def weighted_samples(draw) -> tuple[np.ndarray, np.ndarray]:
    count, size = draw(st.integers(1, 30)), draw(st.integers(1, 6))
    states = draw(arrays(np.float64, (count, size), elements=st.floats(-1e6, 1e6)))
    logs = draw(arrays(np.float64, count, elements=st.floats(-1e5, 0.0)))
    return states, np.exp(normalise_log_weights(logs).log_weights)


def test_mean_by_hand():
    np.testing.assert_allclose(weighted_mean(STATES, STATE_WEIGHTS), [1.0, 2.0])


def test_covariance_by_hand():
    covariance = weighted_covariance(STATES, STATE_WEIGHTS, np.array([1.0, 2.0]))
    np.testing.assert_allclose(covariance, [[3.0, -1.0], [-1.0, 3.0]])


def test_covariance_about_another_point_is_the_moment_about_that_point():
    moment = weighted_covariance(STATES, STATE_WEIGHTS, np.zeros(2))
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
