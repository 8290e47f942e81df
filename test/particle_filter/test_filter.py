from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.particle_filter.estimates import weighted_covariance, weighted_mean

FOUR = np.arange(4.0)[:, None]
MILD = np.log([0.30, 0.26, 0.24, 0.20])
SEVERE = np.log([0.97, 0.01, 0.01, 0.01])


def test_without_resampling_the_next_likelihood_multiplies_the_weights(make_filter):
    belief = make_filter(FOUR)
    belief.step(1.0, MILD)
    belief.step(1.0, MILD)
    product = np.exp(2 * MILD)
    np.testing.assert_allclose(belief.particles.weights, product / product.sum())
    np.testing.assert_array_equal(belief.particles.states, FOUR)


def test_resampling_forgets_the_weights_and_keeps_them_in_the_numbers(make_filter):
    belief = make_filter(FOUR)
    belief.step(1.0, SEVERE)
    assert belief.resample_if_degenerate()
    np.testing.assert_allclose(belief.particles.weights, 0.25)
    assert (belief.particles.states == 0.0).sum() >= 3


def test_resampling_comes_before_the_next_observation(make_filter):
    belief = make_filter(FOUR)
    belief.step(1.0, SEVERE)
    np.testing.assert_allclose(belief.particles.weights, np.exp(SEVERE), rtol=1e-12)
    belief.step(1.0, MILD)
    np.testing.assert_allclose(belief.particles.weights, np.exp(MILD), rtol=1e-12)


@pytest.mark.parametrize("likelihoods", [MILD, SEVERE, np.array([0.0, *[-np.inf] * 3])])
def test_a_threshold_of_zero_never_resamples(make_filter, likelihoods):
    belief = make_filter(FOUR, threshold=0.0)
    belief.update(likelihoods)
    assert not belief.resample_if_degenerate()


@pytest.mark.parametrize("count", [1, 4, 5, 7, 14, 500])
def test_a_threshold_of_one_always_resamples_except_equal_weights(make_filter, count):
    belief = make_filter(np.zeros((count, 1)), threshold=1.0)
    assert not belief.resample_if_degenerate()
    if count > 1:
        belief.update(np.linspace(0.0, 0.1, count))
        assert belief.resample_if_degenerate()


@pytest.mark.parametrize("excluded", [np.full(4, -np.inf), np.full(4, np.nan)])
def test_an_observation_that_excludes_everything_leaves_the_prior(make_filter, excluded):
    belief = make_filter(FOUR)
    belief.update(MILD)
    before = belief.particles.weights
    assert belief.update(excluded) == -np.inf
    np.testing.assert_array_equal(belief.particles.weights, before)


def test_one_particle_survives_everything(make_filter):
    belief = make_filter([[3.0]], variance=1.0)
    for likelihood in (-1e5, np.nan, -np.inf, 0.0, np.inf):
        belief.step(0.1, np.array([likelihood]))
    assert belief.particles.weights.tolist() == [1.0]
    assert np.isfinite(belief.particles.states).all()


def test_likelihoods_around_1e_300_decide_as_those_around_one_do(make_filter):
    tiny, usual = make_filter(FOUR), make_filter(FOUR)
    log_evidence = tiny.update(MILD + np.log(1e-300))
    assert log_evidence == pytest.approx(usual.update(MILD) + np.log(1e-300), rel=1e-12)
    np.testing.assert_allclose(tiny.particles.weights, usual.particles.weights, rtol=1e-9)


def test_the_evidence_is_the_likelihood_averaged_over_the_prior(make_filter):
    assert make_filter(FOUR).update(np.log([1.0, 2.0, 3.0, 4.0])) == pytest.approx(np.log(2.5))


@pytest.mark.parametrize("count", [1, 3, 1000])
def test_the_number_of_particles_can_change(make_filter, count):
    belief = make_filter(FOUR)
    belief.update(np.array([0.0, -np.inf, 0.0, -np.inf]))
    belief.resample(count)
    assert belief.particles.count == count
    assert set(belief.particles.states[:, 0]) <= {0.0, 2.0}


def test_the_same_seed_gives_the_same_particles(make_filter, noisy_position):
    runs = [
        make_filter(np.zeros((50, 1)), variance=1.0, seed=seed, observation=noisy_position(1.0))
        for seed in (3, 3, 4)
    ]
    for belief in runs:
        for position in (0.5, 1.0, 2.0):
            belief.step(0.1, position)
    first, same, other = (belief.particles.states for belief in runs)
    np.testing.assert_array_equal(first, same)
    assert (first != other).any()


def kalman(positions, *, mean, variance, walk, noise, dt):
    """Mean and variance of a random walk that is measured with noise, after each measurement."""
    history = []
    for position in positions:
        variance += walk * dt
        gain = variance / (variance + noise)
        mean += gain * (position - mean)
        variance *= 1 - gain
        history.append((mean, variance))
    return np.array(history)


@pytest.mark.parametrize("threshold", [0.0, 0.5, 1.0])
def test_a_linear_gaussian_model_agrees_with_a_kalman_filter(
    make_filter, noisy_position, rng, threshold
):
    walk, noise, dt, count = 2.0, 0.5, 0.1, 20_000
    truth = np.cumsum(rng.standard_normal(12) * np.sqrt(walk * dt))
    positions = truth + rng.standard_normal(12) * np.sqrt(noise)
    belief = make_filter(
        rng.standard_normal((count, 1)),
        variance=walk,
        threshold=threshold,
        observation=noisy_position(noise),
    )
    found = []
    for position in positions:
        belief.step(dt, position)
        states, weights = belief.particles.states, belief.particles.weights
        variance = weighted_covariance(states, weights)[0, 0]
        found.append((weighted_mean(states, weights)[0], variance))
    expected = kalman(positions, mean=0.0, variance=1.0, walk=walk, noise=noise, dt=dt)
    sigma = np.sqrt(expected[:, 1])
    means, variances = np.array(found).T
    # The Monte Carlo error is about sigma / sqrt(N_eff); without resampling N_eff gets small.
    tolerance = 0.25 if threshold == 0.0 else 0.05
    assert (np.abs(means - expected[:, 0]) < tolerance * sigma).all()
    np.testing.assert_allclose(variances, expected[:, 1], rtol=2 * tolerance)
