from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.frame_noise import draw_frame_noise
from cable_tracker.cable.hypotheses.mixture_sample import Drawn, MixtureSample, log_density
from cable_tracker.cable.hypotheses.prior_density import PriorDensities
from cable_tracker.cable.measure.likelihood_ratio import CableEvidence
from cable_tracker.particle_filter.kernel_mixture import KernelMixture
from cable_tracker.particle_filter.student_t import StudentT

PEAK = StudentT(np.array([1.0, 0.0, 30.0, 0.0]), np.diag([1.0, 0.1, 2.0, 0.1]), 4.0)
CLOUD = KernelMixture(
    np.array([[0.0, 0.0, 30.0, 0.0], [5.0, 0.1, 25.0, 0.0]]), np.array([1.0, 0.1, 1.0, 0.1]), 4.0
)


def drawn(places, full, survivors, births, log_ratios) -> Drawn:
    count = len(places)
    columns = [np.broadcast_to(x, count).astype(float) for x in (full, survivors, births)]
    return Drawn(
        np.hstack((places, np.zeros((count, 4)))),
        PriorDensities(columns[0], columns[0], columns[1], columns[2]),
        np.broadcast_to(log_ratios, count).astype(float),
        np.zeros(count),
        CableEvidence(np.zeros((count, 2)), np.zeros((count, 2)), np.zeros(count)),
    )


def standard(count, rng) -> np.ndarray:
    return draw_frame_noise(rng, count, 0, 4.0).of_places(slice(None))


def test_a_particle_weighs_prior_times_likelihood_over_the_whole_mixture(rng):
    places = PEAK.placed(standard(6, rng))
    sample = MixtureSample(
        drawn(places, -3.0, -2.0, -5.0, 1.5), 10, 4, ((3, PEAK), (7, CLOUD), (0, PEAK))
    )
    mixture = 10 * math.exp(-2) + 4 * math.exp(-5) + 3 * np.exp(PEAK.log_density(places))
    mixture += 7 * np.exp(log_density(CLOUD, places))
    for power in (0.0, 0.3, 1.0):
        expected = -3.0 + power * 1.5 - np.log(mixture)
        np.testing.assert_allclose(sample.log_weights(power), expected)


def test_what_is_impossible_weighs_nothing_and_before_it_is_looked_at_something(rng):
    sample = MixtureSample(
        drawn(PEAK.placed(standard(2, rng)), -3.0, -2.0, -5.0, -math.inf), 1, 1, ()
    )
    with np.errstate(all="raise"):
        assert (sample.log_weights(1.0) == -math.inf).all()
        assert np.isfinite(sample.log_weights(0.0)).all()


def test_a_cloud_is_a_proposal_with_equal_weights(rng):
    places = PEAK.placed(standard(5, rng))
    halves = CLOUD.log_densities(places, (np.array([0.5, 0.5]),))[0]
    np.testing.assert_allclose(log_density(CLOUD, places), halves)


def test_more_particles_join_with_their_proposals(rng):
    first, second = (
        drawn(PEAK.placed(standard(n, rng)), -1.0, -2.0, -3.0, float(n)) for n in (2, 3)
    )
    sample = MixtureSample(first, 1, 1, ()).extended(second, ((3, PEAK),))
    assert sample.drawn.log_ratios.tolist() == [2.0, 2.0, 3.0, 3.0, 3.0]
    assert sample.drawn.states.shape == (5, 8)
    assert sample.drawn.evidence.seen.shape == (5,)
    assert sample.proposals == ((3, PEAK),)


def test_the_weights_sum_to_the_mass_of_the_prior_wherever_particles_are_drawn(rng):
    """Self-normalising is no excuse: for a likelihood of one the sum itself is known."""
    count = 4000
    about_peak, about_cloud = standard(count, rng), standard(count, rng)
    places = np.concatenate(
        (PEAK.placed(about_peak), CLOUD.placed_about(np.arange(count) % 2, about_cloud))
    )
    full = math.log(0.7) + PEAK.log_density(places)
    sample = MixtureSample(
        drawn(places, full, -math.inf, -math.inf, 0.0), 0, 0, ((count, PEAK), (count, CLOUD))
    )
    assert np.exp(sample.log_weights(1.0)).sum() == pytest.approx(0.7, rel=0.03)
