from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.mixture_sample import (
    Peaks,
    add_detections,
    add_peaks,
    find_peaks,
    log_weights,
    marginal_ratios,
)

FACTOR = np.linalg.cholesky(
    np.array([[4.0, 0.02, 0, 0], [0.02, 0.001, 0, 0], [0, 0, 9.0, 0.02], [0, 0, 0.02, 0.001]])
)
PLACE = np.array([5.0, 0.2, 30.0, 0.0])
SCALES = np.array([3.0, 0.03, 4.0, 0.03])


def literal_density(point, place, factor) -> float:
    """A Student-t of four degrees of freedom with a full scale matrix."""
    standard = np.linalg.solve(factor, point - place)
    peak = 6.0 / (4.0 * math.pi) ** 2 / np.prod(np.diag(factor))
    return peak * (1.0 + standard @ standard / 4.0) ** -4.0


def points_about(rng, count=20) -> np.ndarray:
    points = PLACE + rng.standard_normal((count, 4)) @ FACTOR.T
    return np.hstack((points, np.zeros((count, 4))))


def test_the_mixture_gains_every_peak_by_its_number_of_particles(rng):
    states, mixture = points_about(rng), np.full(20, 0.5)
    peaks = Peaks(np.array([7, 0]), np.array([PLACE, PLACE]), np.array([FACTOR, FACTOR]))
    add_peaks(states, 0, 20, peaks, 0, 2, 4.0, mixture)
    expected = [0.5 + 7 * literal_density(state[:4], PLACE, FACTOR) for state in states]
    np.testing.assert_allclose(mixture, expected)


def test_detections_are_a_mixture_of_equal_kernels(rng):
    states, mixture = points_about(rng), np.zeros(20)
    centres = np.array([PLACE, PLACE + 3.0])
    add_detections(states, 0, 20, 10.0, centres, SCALES, 4.0, mixture)
    factor = np.diag(SCALES)
    expected = [
        10 * np.mean([literal_density(state[:4], centre, factor) for centre in centres])
        for state in states
    ]
    np.testing.assert_allclose(mixture, expected)


def test_a_particle_weighs_prior_times_likelihood_over_the_mixture():
    ratios, full, mixture = np.array([1.5, -2.0]), np.array([0.3, 0.2]), np.array([4.0, 5.0])
    for power in (0.0, 0.3, 1.0):
        expected = power * ratios + np.log(full / mixture)
        np.testing.assert_allclose(log_weights(power, ratios, full, mixture), expected)


def test_what_is_impossible_weighs_nothing_but_can_be_compared_before_the_frame():
    impossible = np.array([-math.inf])
    one = np.ones(1)
    assert log_weights(1.0, impossible, one, one)[0] == -math.inf
    assert log_weights(0.0, impossible, one, one)[0] == 0.0
    assert log_weights(1.0, one, np.zeros(1), one)[0] == -math.inf


def test_poses_beyond_a_limit_are_impossible_and_others_have_the_width_counted():
    states = np.zeros((3, 8))
    states[:, 2] = [30.0, 300.0, 30.0]
    states[2, 3] = 0.2  # The borders meet 74 px from the centre.
    lower, upper = np.array([-100, -np.inf, 8, -0.3]), np.array([100, np.inf, 160, 0.3])
    marginal = np.empty(3)
    marginal_ratios(
        states, 0, 3, np.full((3, 2), 2.0), 0.3, np.full(3, -0.5), lower, upper, (320.0, 240.0),
        marginal,
    )  # fmt: skip
    assert marginal[0] == pytest.approx(1.5)
    assert (marginal[1:] == -math.inf).all()


def test_peaks_have_the_mean_and_the_widened_covariance_of_the_clusters(rng):
    states = points_about(rng, 200)
    log_shares = np.full(200, -math.log(200))
    masses, means, factors = find_peaks(states, log_shares, 320.0, 3, 0.02, 1.5, SCALES)
    inside = np.abs(states[:, 0] - PLACE[0]) < 100.0
    assert masses[0] == pytest.approx(1.0, abs=0.1)
    np.testing.assert_allclose(means[0], states[inside, :4].mean(axis=0), atol=0.5)
    spread = factors[0] @ factors[0].T - np.diag(SCALES**2)
    np.testing.assert_allclose(np.diag(spread), 1.5 * np.diag(FACTOR @ FACTOR.T), rtol=0.5)
