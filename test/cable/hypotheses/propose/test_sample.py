from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.propose.sample import (
    Sample,
    empty_sample,
    fill_log_likelihoods,
    importance_log_weights,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import polarity_prior
from cable_tracker.cable.model.limits import StateLimits


def sample_of(log_likelihoods, prior, proposal) -> Sample:
    sample = empty_sample(len(prior))
    densities = sample.densities._replace(prior=np.array(prior))
    return sample._replace(
        densities=densities,
        log_likelihoods=np.array(log_likelihoods),
        proposal_density=np.array(proposal),
    )


def test_a_particle_weighs_prior_times_likelihood_over_the_mixture():
    sample = sample_of([1.5, -2.0, 9.0], [0.3, 0.2, 9.0], [4.0, 5.0, 9.0])
    for power in (0.0, 0.3, 1.0):
        ratios = np.log(sample.densities.prior / sample.proposal_density)
        expected = power * sample.log_likelihoods + ratios
        np.testing.assert_allclose(importance_log_weights(sample, 2, power), expected[:2])


def test_what_is_impossible_weighs_nothing_but_can_be_compared_before_the_frame():
    impossible = sample_of([-math.inf], [1.0], [1.0])
    assert importance_log_weights(impossible, 1, 1.0)[0] == -math.inf
    assert importance_log_weights(impossible, 1, 0.0)[0] == 0.0
    assert importance_log_weights(sample_of([1.0], [0.0], [1.0]), 1, 1.0)[0] == -math.inf


def test_poses_beyond_a_limit_are_impossible_and_others_have_the_width_counted():
    sample = empty_sample(3)
    sample.states[:] = 0.0
    sample.states[:, 2] = [30.0, 300.0, 30.0]
    sample.states[2, 3] = 0.2  # The borders meet 74 px from the centre.
    sample.measured.log_ratios[:] = 2.0
    sample.densities.width_penalties[:] = -0.5
    limits = StateLimits(np.array([-100, -np.inf, 8, -0.3]), np.array([100, np.inf, 160, 0.3]))
    fill_log_likelihoods(sample, 0, 3, polarity_prior(0.3), limits, (320.0, 240.0))
    assert sample.log_likelihoods[0] == pytest.approx(1.5)
    assert (sample.log_likelihoods[1:] == -math.inf).all()
