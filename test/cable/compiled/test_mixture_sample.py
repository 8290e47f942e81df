from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.clusters import find_clusters
from cable_tracker.cable.hypotheses.mixture_sample import log_density
from cable_tracker.cable.measure.likelihood_ratio import bright_shares, marginal_log_ratios
from cable_tracker.particle_filter.kernel_mixture import KernelMixture
from cable_tracker.particle_filter.student_t import StudentT
from cable_tracker.particle_filter.weights import log_sum_exp

pytest.importorskip("numba")

from cable_tracker.cable.compiled.mixture_sample import (
    Balance,
    Peaks,
    add_detections,
    add_peaks,
    balance,
    find_peaks,
    log_weights,
    marginal_ratios,
    summary,
)

SEEDS = st.integers(0, 2**32 - 1)
TAILS = st.sampled_from([4.0, 1.0, 30.0, math.inf])
SCALES = np.array([3.0, 0.03, 4.0, 0.03])
UNIT = np.array([20.0, 0.2, 20.0, 0.2])


def any_states(rng, count) -> np.ndarray:
    states = rng.standard_normal((count, 8)) * np.tile(UNIT, 2)
    states[:, 2] += 60.0
    return states


@given(SEEDS, st.floats(0.02, 0.98))
def test_ratios_are_averaged_over_the_polarity_and_impossible_beyond_limits(seed, bright):
    rng = np.random.default_rng(seed)
    states, factors = any_states(rng, 30), -rng.random(30)
    ratios = rng.uniform(-300, 300, (30, 2))
    lower, upper = -UNIT, UNIT + np.array([0.0, 0.0, 60.0, 0.0])
    states[0, :4], states[1, :4] = lower, upper
    found = np.full(30, 7.0)
    marginal_ratios(states, 0, 29, ratios, bright, factors, lower, upper, found)
    inside = ((states[:, :4] >= lower) & (states[:, :4] <= upper)).all(axis=1)
    assert inside[:2].all()
    expected = np.where(inside, marginal_log_ratios(ratios, bright) + factors, -np.inf)
    np.testing.assert_allclose(found[:29], expected[:29])
    assert found[29] == 7.0


@given(SEEDS, TAILS, st.integers(1, 6))
def test_detections_add_their_density(seed, tail, detections):
    rng = np.random.default_rng(seed)
    states, centres = any_states(rng, 20), any_states(rng, detections)[:, :4].copy()
    states[:10, :4] = centres[0] + rng.standard_normal((10, 4)) * SCALES
    mixture = rng.random(20) * 1e-6
    expected = mixture + 50.0 * np.exp(
        log_density(KernelMixture(centres, SCALES, tail), states[:, :4])
    )
    add_detections(states, 0, 20, 50.0, centres, SCALES, tail, mixture)
    np.testing.assert_allclose(mixture, expected, rtol=1e-6)


@given(SEEDS, TAILS)
def test_peaks_add_their_densities_and_those_without_particles_none(seed, tail):
    rng = np.random.default_rng(seed)
    states = any_states(rng, 20)
    counts = np.array([12, 0, 5])
    factors = np.linalg.cholesky(
        np.array([np.diag(SCALES**2) + np.outer(a, a) for a in rng.normal(0, 1, (3, 4)) * SCALES])
    )
    locations = any_states(rng, 3)[:, :4].copy()
    states[:10, :4] = locations[0] + rng.standard_normal((10, 4)) @ factors[0].T
    mixture = rng.random(20) * 1e-6
    expected = mixture.copy()
    for count, location, factor in zip(counts, locations, factors, strict=True):
        expected += count * np.exp(StudentT(location, factor, tail).log_density(states[:, :4]))
    before = mixture[15:].copy()
    add_peaks(states, 0, 15, Peaks(counts, locations, factors), 0, 3, tail, mixture)
    np.testing.assert_allclose(mixture[:15], expected[:15], rtol=1e-6)
    np.testing.assert_array_equal(mixture[15:], before)


@given(SEEDS, TAILS, st.integers(0, 3))
def test_peaks_may_be_added_a_few_at_a_time(seed, tail, first):
    rng = np.random.default_rng(seed)
    states, locations = any_states(rng, 20), any_states(rng, 3)[:, :4].copy()
    peaks = Peaks(np.array([12, 3, 5]), locations, np.tile(np.diag(SCALES), (3, 1, 1)))
    whole, parts = rng.random((2, 1)) * np.full((2, 20), 1e-6)
    parts[:] = whole
    add_peaks(states, 0, 20, peaks, 0, 3, tail, whole)
    add_peaks(states, 0, 20, peaks, 0, first, tail, parts)
    add_peaks(states, 0, 20, peaks, first, 3, tail, parts)
    np.testing.assert_array_equal(parts, whole)


@given(SEEDS, st.sampled_from([0.0, 0.3, 1.0]))
def test_a_particle_weighs_prior_times_likelihood_over_the_mixture(seed, power):
    rng = np.random.default_rng(seed)
    ratios, full, mixture = rng.uniform(-50, 50, 20), rng.random(20), rng.random(20)
    expected = power * ratios + np.log(full) - np.log(mixture)
    np.testing.assert_allclose(log_weights(power, ratios, full, mixture), expected, atol=1e-12)


def test_what_is_impossible_or_too_small_for_numbers_weighs_nothing():
    ratios = np.array([-math.inf, 3.0, 3.0, 3.0])
    full, mixture = np.array([1.0, 0.0, 1.0, 0.0]), np.array([1.0, 1.0, 0.0, 0.0])
    np.testing.assert_array_equal(log_weights(1.0, ratios, full, mixture), -np.inf)
    weights = log_weights(0.0, ratios, full, mixture)
    np.testing.assert_array_equal(weights, [0.0, -np.inf, -np.inf, -np.inf])


@given(SEEDS, st.integers(1, 60))
def test_peaks_are_the_heaviest_clusters(seed, count):
    rng = np.random.default_rng(seed)
    states = any_states(rng, count) * rng.choice([0.3, 3.0])
    weights = rng.dirichlet(np.full(count, 0.3))
    smallest, widening, least = 0.05 * SCALES, 1.5, 0.02
    clusters = find_clusters(states, weights, 320)[:3]
    worthy = [clusters[0], *(each for each in clusters[1:] if each.mass >= least)]
    with np.errstate(divide="ignore"):
        log_shares = np.log(weights)
    masses, means, factors = find_peaks(states, log_shares, 320.0, 3, least, widening, smallest)
    np.testing.assert_allclose(masses, [each.mass for each in worthy])
    for cluster, mean, factor in zip(worthy, means, factors, strict=True):
        np.testing.assert_allclose(mean, cluster.mean[:4], atol=1e-9)
        spread = widening * cluster.covariance(states, weights)[:4, :4] + np.diag(smallest**2)
        np.testing.assert_allclose(factor, np.linalg.cholesky(spread), rtol=1e-6, atol=1e-9)


RULES = Balance(evidence_of_bottom=1.0, evidence_limit=4.0, evidence_repeated=0.2)


@given(SEEDS, st.integers(1, 3))
def test_between_groups_only_the_evidence_that_counts_is_left(seed, groups):
    rng = np.random.default_rng(seed)
    count = 40
    labels = rng.integers(-1, groups, count)
    log_prior = rng.uniform(-5, 0, count)
    log_posterior = log_prior + rng.uniform(-4, 12, count)
    log_posterior[rng.random(count) < 0.2] = -np.inf
    full = rng.random(count)
    survived = full * rng.random(count)
    full[0], survived[0] = 0.0, 0.0
    misfits = -rng.random(count)
    found = balance(log_posterior, log_prior, full, survived, misfits, labels, groups, RULES)
    for label in range(-1, groups):
        members = labels == label
        if not np.isfinite(log_posterior[members]).any():
            np.testing.assert_array_equal(found[members], log_posterior[members])
            continue
        before, after = log_sum_exp(log_posterior[members]), log_sum_exp(found[members])
        prior_mass = log_sum_exp(log_prior[members])
        misfit = np.exp(log_posterior[members] - before) @ misfits[members]
        kept = np.divide(survived, full, out=np.zeros(count), where=full > 0)[members]
        share = min(np.exp(log_prior[members] - prior_mass) @ kept, 1.0)
        new = min(before - prior_mass - 1.0, 4.0 + misfit)
        assert after - prior_mass == pytest.approx(new * (share * 0.2 + 1.0 - share), abs=1e-9)
        # Within a group particles compete as before.
        possible = members & np.isfinite(log_posterior)
        shifts = found[possible] - log_posterior[possible]
        assert np.ptp(shifts) == pytest.approx(0.0, abs=1e-9)


@given(SEEDS, st.floats(0.02, 0.98))
def test_the_summary_is_over_the_leader_and_the_polarity_over_all(seed, bright):
    rng = np.random.default_rng(seed)
    weights, labels = rng.dirichlet(np.ones(30)), rng.integers(-1, 2, 30)
    labels[0] = 1
    ratios, weaker, seen = rng.normal(0, 500, (30, 2)), rng.normal(0, 1, (30, 2)), rng.random(30)
    mass = weights[labels == 1].sum()
    evidence, points, brightness = summary(labels, 1, mass, weights, ratios, weaker, seen, bright)
    shares = bright_shares(ratios, bright)
    within = weights * (labels == 1) / mass
    chosen = np.where(shares >= 0.5, weaker[:, 0], weaker[:, 1])
    assert evidence == pytest.approx(within @ chosen, abs=1e-9)
    assert points == pytest.approx(within @ seen)
    assert brightness == pytest.approx(weights @ shares)
