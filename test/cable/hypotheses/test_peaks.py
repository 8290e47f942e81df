from __future__ import annotations

import math

import numpy as np

from cable_tracker.cable.hypotheses.frame_inputs import draw_frame_noise, frame_config
from cable_tracker.cable.hypotheses.peaks import (
    MOST_REFINED,
    Peaks,
    add_detection_density,
    add_peak_densities,
    all_peaks,
    candidate_peaks,
    cluster_peaks,
    draw_about_peaks,
    no_peaks,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters

FACTOR = np.linalg.cholesky(
    np.array([[4.0, 0.02, 0, 0], [0.02, 0.001, 0, 0], [0, 0, 9.0, 0.02], [0, 0, 0.02, 0.001]])
)
PLACE = np.array([5.0, 0.2, 30.0, 0.0])
SCALES = np.array([3.0, 0.03, 4.0, 0.03])
CONFIG = frame_config(TrackerParameters(), 4.0, (320, 240))


def literal_density(point, place, factor) -> float:
    """A Student-t of four degrees of freedom with a full scale matrix."""
    standard = np.linalg.solve(factor, point - place)
    peak = 6.0 / (4.0 * math.pi) ** 2 / np.prod(np.diag(factor))
    return peak * (1.0 + standard @ standard / 4.0) ** -4.0


def points_about(rng, count=20) -> np.ndarray:
    points = PLACE + rng.standard_normal((count, 4)) @ FACTOR.T
    return np.hstack((points, np.zeros((count, 4))))


def test_the_mixture_gains_every_peak_by_its_number_of_particles(rng):
    states, density = points_about(rng), np.full(20, 0.5)
    peaks = Peaks(np.array([7, 0]), np.array([PLACE, PLACE]), np.array([FACTOR, FACTOR]))
    add_peak_densities(states, 0, 20, peaks, 4.0, density)
    expected = [0.5 + 7 * literal_density(state[:4], PLACE, FACTOR) for state in states]
    np.testing.assert_allclose(density, expected)


def test_detections_are_a_mixture_of_equal_kernels(rng):
    states, density = points_about(rng), np.zeros(20)
    centres = np.array([PLACE, PLACE + 3.0])
    config = CONFIG._replace(detection_sigmas=SCALES)
    add_detection_density(states, 0, 20, 10, centres, config, density)
    factor = np.diag(SCALES)
    expected = [
        10 * np.mean([literal_density(state[:4], centre, factor) for centre in centres])
        for state in states
    ]
    np.testing.assert_allclose(density, expected)


def test_peaks_have_the_mean_and_the_widened_covariance_of_the_clusters(rng):
    states = points_about(rng, 200)
    log_weights = np.full(200, -math.log(200))
    config = CONFIG._replace(smallest_sigmas=SCALES)
    peaks = cluster_peaks(states, log_weights, 50, 1.5, config)
    assert 1 <= len(peaks.counts) <= MOST_REFINED
    assert peaks.counts.sum() == 50
    assert peaks.counts[0] >= 45
    inside = np.abs(states[:, 0] - PLACE[0]) < 100.0
    np.testing.assert_allclose(peaks.locations[0], states[inside, :4].mean(axis=0), atol=0.5)
    factor = np.tril(peaks.factors[0])
    spread = factor @ factor.T - np.diag(SCALES**2)
    np.testing.assert_allclose(np.diag(spread), 1.5 * np.diag(FACTOR @ FACTOR.T), rtol=0.5)


def test_candidates_become_peaks_that_share_the_particles_out():
    strips = np.hstack((np.array([PLACE, PLACE + 3.0, PLACE - 3.0]), np.zeros((3, 4))))
    config = CONFIG._replace(detection_sigmas=SCALES, smallest_sigmas=np.full(4, 0.1))
    peaks = candidate_peaks(strips, 11, 0.5, config)
    assert sorted(peaks.counts) == [3, 4, 4]
    np.testing.assert_array_equal(peaks.locations, strips[:, :4])
    for factor in peaks.factors:
        np.testing.assert_allclose(factor, np.diag([1.5, 0.1, 2.0, 0.1]))


def test_draws_about_a_peak_have_its_mean_and_covariance(rng):
    peaks = Peaks(np.array([0, 4000]), np.array([PLACE, PLACE]), np.array([FACTOR, FACTOR]))
    noise = draw_frame_noise(rng, 4001, 0, math.inf)
    states = np.full((4001, 8), 7.0)
    draw_about_peaks(states, 1, noise, peaks)
    assert (states[0] == 7.0).all()
    np.testing.assert_allclose(states[1:, :4].mean(axis=0), PLACE, atol=0.2)
    covariance = np.cov(states[1:, :4].T)
    np.testing.assert_allclose(np.diag(covariance), np.diag(FACTOR @ FACTOR.T), rtol=0.1)


def test_peaks_are_put_one_after_the_other():
    strips = np.hstack((np.array([PLACE, PLACE + 3.0]), np.zeros((2, 4))))
    first, others = (candidate_peaks(strips[k : k + 1], 5 + k, 0.5, CONFIG) for k in range(2))
    both = all_peaks(all_peaks(no_peaks(), first), others)
    np.testing.assert_array_equal(both.counts, [5, 6])
    np.testing.assert_array_equal(both.locations, strips[:, :4])
    assert both.factors.shape == (2, 4, 4)
