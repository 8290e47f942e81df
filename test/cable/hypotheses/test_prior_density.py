from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.frame_noise import draw_frame_noise
from cable_tracker.cable.hypotheses.leaving import BirthDensity
from cable_tracker.cable.hypotheses.prior_density import Prior, PriorDensities
from cable_tracker.cable.hypotheses.usual_width import UsualWidth
from cable_tracker.cable.model.initialisation import search_box
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import PredictedExistence
from cable_tracker.particle_filter.kernel_mixture import KernelMixture

PARAMETERS = TrackerParameters(width_spread=0.3)
CENTRES = np.array([[-40.0, 0.0, 30.0, 0.0], [40.0, 0.1, 30.0, 0.0]])
RATES = np.array([[-100.0, 0.0, 0.0, 0.0], [100.0, 0.0, 0.0, 0.0]])


def make_prior(survived=0.8, born=0.1, target=(0.9, 0.1), usual_width=None) -> Prior:
    return Prior(
        kernels=KernelMixture(CENTRES, np.array([2.0, 0.02, 1.0, 0.02]), 4.0),
        target=np.array(target),
        proposal=np.array([0.5, 0.5]),
        rates=RATES,
        rate_sigmas=np.array([1.0, 0.1, 1.0, 0.1]),
        births=BirthDensity(search_box(PARAMETERS, 320), None, 4.0, (320, 240)),
        existence=PredictedExistence(survived, born),
        reference_angle=0.0,
        usual_width=usual_width,
        parameters=PARAMETERS,
        leader_shift=np.zeros(4),
    )


def states_at(*places) -> np.ndarray:
    return np.hstack((np.array(places, dtype=float), np.zeros((len(places), 4))))


def rates_at(prior, states, rng) -> np.ndarray:
    noise = draw_frame_noise(rng, len(states), 0, prior.kernels.degrees_of_freedom)
    return prior.rates_from(states, noise.uniform, noise.of_rates(slice(None)))


def test_the_prior_is_what_survived_and_what_was_born_by_their_masses():
    prior, states = make_prior(), states_at(*CENTRES, [100.0, 1.0, 50.0, 0.0])
    densities = prior.log_densities(states)
    moved = prior.kernels.log_densities(states[:, :4], (prior.target, prior.proposal))
    expected = 0.8 * np.exp(moved[0]) + 0.1 * np.exp(prior.births.log_density(states))
    np.testing.assert_allclose(np.exp(densities.full), expected)
    np.testing.assert_allclose(densities.survivors, moved[1])
    shares = np.exp(densities.log_share_of_survivors())
    assert (shares[:2] > 0.99).all()
    assert shares[2] < 0.01


def test_a_new_cable_of_another_width_is_less_likely():
    states = states_at([100.0, 1.0, 30.0, 0.0], [100.0, 1.0, 90.0, 0.0])
    usual, other = make_prior(usual_width=UsualWidth(math.log(30.0))).log_densities(states).full
    assert usual - other > 2.0
    assert np.ptp(make_prior().log_densities(states).full) < 1e-3


def test_where_the_prior_vanishes_nothing_survived():
    nowhere = np.array([-np.inf])
    with np.errstate(all="raise"):
        share = PriorDensities(nowhere, nowhere, nowhere, nowhere).log_share_of_survivors()
    assert share[0] == -np.inf


def test_nothing_may_be_born_or_survive(rng):
    for survived, born in ((0.0, 0.5), (0.5, 0.0)):
        prior = make_prior(survived, born)
        states = states_at(*CENTRES)
        assert np.isfinite(prior.log_densities(states).full).all()
        assert np.isfinite(rates_at(prior, states, rng)).all()


def test_a_place_that_was_proposed_has_the_rates_of_who_would_have_moved_there(rng):
    prior = make_prior()
    rates = rates_at(prior, states_at(*np.repeat(CENTRES, 200, axis=0)), rng)
    assert rates.shape == (400, 4)
    np.testing.assert_allclose(np.median(rates[:200], axis=0), RATES[0], atol=0.5)
    np.testing.assert_allclose(np.median(rates[200:], axis=0), RATES[1], atol=0.5)


def test_between_two_ancestors_the_likelier_one_is_chosen_more_often(rng):
    middle = CENTRES.mean(axis=0)
    rates = rates_at(make_prior(born=0.0), states_at(*[middle] * 4000), rng)
    assert (rates[:, 0] < 0.0).mean() == pytest.approx(0.9, abs=0.03)


def test_far_from_all_ancestors_it_has_the_rates_of_the_search(rng):
    prior = make_prior()
    rates = rates_at(prior, states_at(*[[150.0, -1.2, 80.0, 0.1]] * 500), rng)
    box = prior.births.box
    assert ((rates >= box.lower[4:]) & (rates <= box.upper[4:])).all(axis=1).mean() > 0.98
    assert np.ptp(rates[:, 0]) > 0.8 * (box.upper - box.lower)[4]


def test_children_have_the_rates_of_their_parents(rng):
    noise = draw_frame_noise(rng, 3, 0, 4.0)
    rates = make_prior().rates_about(np.array([0, 1, 1]), noise.of_rates(slice(None)))
    assert np.sign(rates[:, 0]).tolist() == [-1.0, 1.0, 1.0]
