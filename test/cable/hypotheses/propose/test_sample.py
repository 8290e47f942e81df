from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.propose.sample import (
    MapWeights,
    Sample,
    empty_sample,
    fill_log_likelihoods,
    fill_map_log_ratios,
    importance_log_weights,
)
from cable_tracker.cable.measure.borders.polarity_prior import polarity_prior
from cable_tracker.cable.measure.map.cable_map import (
    NO_MAP,
    beside_expected,
    cable_map_of,
    map_overlap,
)
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


def a_map_and_strips_on_it_and_beside_it():
    sample = empty_sample(2)
    sample.states[:] = 0.0
    sample.states[:, 0] = [0.0, 60.0]
    sample.states[:, 2] = 24.0
    shown = np.zeros((60, 80), np.float32)
    shown[:, 37:43] = 0.9
    cable_map = cable_map_of(shown, -158.0, 118.0, 4.0)
    on_it, beside = (map_overlap(state, cable_map) for state in sample.states)
    assert on_it > 1.0 > -1.0 > beside
    return cable_map, sample, on_it, beside


def test_a_particle_on_what_the_map_shows_weighs_more_but_no_more_than_is_enough():
    cable_map, sample, on_it, beside = a_map_and_strips_on_it_and_beside_it()
    weights = MapWeights(overlap=3.0, lacking=2.0)
    fill_map_log_ratios(sample, 0, 2, cable_map, weights)
    assert sample.map_log_ratios.tolist() == pytest.approx([3.0 * on_it, 3.0 * beside])
    fill_map_log_ratios(sample, 0, 2, cable_map._replace(enough=1.0), weights)
    assert sample.map_log_ratios.tolist() == pytest.approx([3.0, 3.0 * beside])
    fill_map_log_ratios(sample, 0, 2, NO_MAP, weights)
    assert sample.map_log_ratios.tolist() == [0.0, 0.0]


def test_what_a_particle_lacks_to_the_expected_strip_counts_besides():
    cable_map, sample, on_it, beside = a_map_and_strips_on_it_and_beside_it()
    expecting = beside_expected(cable_map, sample.states[0])
    assert expecting.expected == on_it
    weights = MapWeights(overlap=3.0, lacking=2.0)
    fill_map_log_ratios(sample, 0, 2, expecting, weights)
    lacking = 2.0 * (on_it - beside)
    assert sample.map_log_ratios.tolist() == pytest.approx([3.0 * on_it, 3.0 * beside - lacking])
    less = expecting._replace(expected=beside)
    fill_map_log_ratios(sample, 0, 2, less, weights)
    assert sample.map_log_ratios.tolist() == pytest.approx([3.0 * on_it, 3.0 * beside])


def test_nothing_is_held_against_a_strip_where_there_is_no_map():
    assert beside_expected(NO_MAP, np.zeros(8)) is NO_MAP
