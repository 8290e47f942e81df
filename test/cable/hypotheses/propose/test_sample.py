from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.propose.sample import (
    NOTHING_EXPECTED,
    SLACK,
    ExpectedOverlap,
    MapWeights,
    Sample,
    empty_sample,
    fill_log_likelihoods,
    importance_log_weights,
    map_log_ratio,
    overlap_of_expected,
)
from cable_tracker.cable.measure.borders.polarity_prior import polarity_prior
from cable_tracker.cable.measure.map.cable_map import NO_MAP, cable_map_of, map_overlap
from cable_tracker.cable.model.limits import StateLimits
from cable_tracker.cable.model.state import CableState

WEIGHTS = MapWeights(overlap=3.0, lacking=2.0)
ON_IT, BESIDE = (CableState(distance, 0.0, 24.0, 0.0).to_array() for distance in (0.0, 60.0))


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


@pytest.fixture(scope="module")
def shown():
    """A map that shows an upright cable in the middle."""
    probabilities = np.zeros((60, 80), np.float32)
    probabilities[:, 37:43] = 0.9
    return cable_map_of(probabilities, -158.0, 118.0, 4.0)


def test_a_particle_on_what_the_map_shows_weighs_more(shown):
    for state in (ON_IT, BESIDE):
        overlap = map_overlap(state, shown)
        found = map_log_ratio(state, shown, NOTHING_EXPECTED, WEIGHTS)
        assert found == pytest.approx(3.0 * overlap)
    assert map_overlap(ON_IT, shown) > 1.0 > -1.0 > map_overlap(BESIDE, shown)


def test_beyond_what_is_enough_a_better_overlap_weighs_no_more(shown):
    against = ExpectedOverlap(enough=1.0, expected=-math.inf)
    assert map_log_ratio(ON_IT, shown, against, WEIGHTS) == pytest.approx(3.0)


def test_without_a_map_no_particle_weighs_more(shown):
    assert map_log_ratio(ON_IT, NO_MAP, NOTHING_EXPECTED, WEIGHTS) == 0.0


def test_what_a_particle_lacks_to_the_expected_strip_counts_besides(shown):
    against = overlap_of_expected(shown, ON_IT, is_kept=False)
    assert against == (math.inf, map_overlap(ON_IT, shown))
    on_it, beside = map_overlap(ON_IT, shown), map_overlap(BESIDE, shown)
    assert map_log_ratio(ON_IT, shown, against, WEIGHTS) == pytest.approx(3.0 * on_it)
    lacking = 2.0 * (on_it - beside)
    assert map_log_ratio(BESIDE, shown, against, WEIGHTS) == pytest.approx(3.0 * beside - lacking)
    less = against._replace(expected=beside)
    assert map_log_ratio(BESIDE, shown, less, WEIGHTS) == pytest.approx(3.0 * beside)


def test_in_a_kept_map_a_strip_that_matches_nearly_as_well_as_the_expected_one_is_as_good(shown):
    """How exactly the cable has moved since is not known: between such strips borders decide."""
    against = overlap_of_expected(shown, ON_IT, is_kept=True)
    assert against.enough == against.expected == map_overlap(ON_IT, shown) - SLACK
    aside, half = ON_IT.copy(), ON_IT.copy()
    aside[0] += 1.0
    half[[0, 2]] = -6.0, 12.0
    expected = map_log_ratio(ON_IT, shown, against, WEIGHTS)
    assert map_log_ratio(aside, shown, against, WEIGHTS) == expected
    assert map_log_ratio(half, shown, against, WEIGHTS) < expected - 1.0


def test_nothing_is_held_against_a_strip_where_there_is_no_map():
    assert overlap_of_expected(NO_MAP, ON_IT, is_kept=False) == NOTHING_EXPECTED
    assert overlap_of_expected(NO_MAP, ON_IT, is_kept=True) == NOTHING_EXPECTED
