from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.frame_inputs import frame_config
from cable_tracker.cable.hypotheses.peaks import MOST_CANDIDATES, likeliest_strips
from cable_tracker.cable.hypotheses.proposals import (
    Sample,
    empty_sample,
    fill_log_likelihoods,
    importance_log_weights,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import polarity_prior
from cable_tracker.cable.model.limits import StateLimits
from cable_tracker.cable.parameters.parameters import TrackerParameters

CONFIG = frame_config(TrackerParameters(), 4.0, (320, 240))
NOTHING = np.empty((0, 4))
CABLE, ELSEWHERE = [40.0, 0.0, 40.0, 0.0], [-80.0, 0.3, 30.0, 0.0]


@pytest.fixture
def candidates(frame_inputs):
    """Return the candidates (C, 4) among poses of some log-likelihoods and strips of a map."""

    def find(picture, poses, log_likelihoods, shown=NOTHING) -> np.ndarray:
        states = np.hstack((np.array(poses), np.zeros((len(poses), 4))))
        map_strips = np.hstack((shown, np.zeros((len(shown), 4))))
        births = SimpleNamespace(map_strips=map_strips)
        inputs = frame_inputs(picture)._replace(predicted=SimpleNamespace(births=births))
        found = likeliest_strips(states, np.array(log_likelihoods), inputs, CONFIG)
        return found[:, :4]

    return find


def picture_of_a_cable(rng) -> np.ndarray:
    picture = rng.normal(100.0, 10.0, (240, 320))
    picture[:, 180:220] = rng.normal(115.0, 2.0, (240, 40))
    return picture


def test_candidates_are_ordered_by_appearance_not_by_likelihood(candidates, rng):
    found = candidates(picture_of_a_cable(rng), [ELSEWHERE, CABLE], [30.0, 1.0])
    np.testing.assert_array_equal(found, [CABLE, ELSEWHERE])


def test_neighbouring_strips_give_one_candidate_the_likeliest(candidates, rng):
    beside = [CABLE[0] + 2.0, *CABLE[1:]]
    found = candidates(picture_of_a_cable(rng), [beside, CABLE, beside], [1.0, 2.0, 0.0])
    np.testing.assert_array_equal(found, [CABLE])


def test_impossible_ones_are_no_candidates(candidates, rng):
    picture = picture_of_a_cable(rng)
    assert len(candidates(picture, [CABLE, ELSEWHERE], [-np.inf, -np.inf])) == 0
    np.testing.assert_array_equal(
        candidates(picture, [CABLE, ELSEWHERE], [-np.inf, 0.0]), [ELSEWHERE]
    )


def test_a_strip_of_the_map_is_a_candidate_without_particles_there(candidates, rng):
    found = candidates(picture_of_a_cable(rng), [ELSEWHERE], [30.0], np.array([CABLE]))
    np.testing.assert_array_equal(found, [CABLE, ELSEWHERE])


def test_their_number_is_limited(candidates, rng):
    poses = [[20.0 * index - 100.0, 0.4 * (index % 3), 20.0, 0.0] for index in range(10)]
    assert len(candidates(picture_of_a_cable(rng), poses, range(10))) == MOST_CANDIDATES


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


def test_an_impossible_particle_has_no_weight_but_for_a_likelihood_to_the_power_of_zero():
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
