from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.births import (
    birth_density,
    births_anywhere,
    drawn_birth_density,
    switch_density,
)
from cable_tracker.cable.hypotheses.frame_inputs import draw_frame_noise
from cable_tracker.cable.hypotheses.predicted_density import (
    DensityValues,
    PredictedDensity,
    empty_densities,
    fill_densities,
)
from cable_tracker.cable.hypotheses.prediction import switch_from
from cable_tracker.cable.hypotheses.proposals import choose_rates
from cable_tracker.cable.model.initial_state import search_box
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.student_t import kernel_mixture

PARAMETERS = TrackerParameters()
CENTRES = np.array([[-40.0, 0.0, 30.0, 0.0], [40.0, 0.1, 30.0, 0.0]])
SWITCH = switch_from(CENTRES[0], 3.0, 240.0, 1.0)
RATES = np.array([[-100.0, 0.0, 0.0, 0.0], [100.0, 0.0, 0.0, 0.0]])
SCALES = np.array([2.0, 0.02, 1.0, 0.02])


def make_predicted(
    mass_survived=0.8,
    mass_born=0.1,
    mass_switched=1e-12,
    log_width=0.0,
    width_spread=math.inf,
    rate_gains=(0.0, 0.0, 0.0, 0.0),
) -> PredictedDensity:
    return PredictedDensity(
        kernels=kernel_mixture(CENTRES, SCALES, 4.0, np.array([0.9, 0.1])),
        rates=RATES,
        rate_gains=np.array(rate_gains),
        rate_scales=np.array([1.0, 0.1, 1.0, 0.1]),
        mass_survived=mass_survived,
        mass_born=mass_born,
        log_width=log_width,
        width_spread=width_spread,
        births=births_anywhere(search_box(PARAMETERS, 320), (320, 240), 1.0),
        mass_switched=mass_switched,
        border_switch=SWITCH,
    )


def states_at(*poses) -> np.ndarray:
    return np.hstack((np.array(poses, dtype=float), np.zeros((len(poses), 4))))


def densities_at(predicted, states) -> DensityValues:
    densities = empty_densities(len(states))
    fill_densities(states, len(states), predicted, densities)
    return densities


def rates_at(predicted, states, rng) -> np.ndarray:
    noise = draw_frame_noise(rng, len(states), 0, 4.0)
    choose_rates(states, 0, len(states), predicted, empty_densities(len(states)), noise)
    return states[:, 4:]


def literal_kernel(state, centre) -> float:
    """A Student-t density of four degrees of freedom in four dimensions."""
    squared = (((state[:4] - centre) / SCALES) ** 2).sum()
    return 6.0 / (4.0 * math.pi) ** 2 / np.prod(SCALES) * (1.0 + squared / 4.0) ** -4.0


def test_the_prior_is_what_survived_and_what_was_born_by_their_masses():
    predicted, states = make_predicted(), states_at(*CENTRES, [100.0, 1.0, 50.0, 0.0])
    densities = densities_at(predicted, states)
    for row, state in enumerate(states):
        first, second = (literal_kernel(state, centre) for centre in CENTRES)
        survived = 0.8 * (0.9 * first + 0.1 * second)
        drawn = drawn_birth_density(state, predicted.births)
        born = 0.1 * birth_density(state, drawn, predicted.births)
        assert densities.prior_survival[row] == pytest.approx(survived, rel=1e-3)
        assert densities.survivor_proposal[row] == pytest.approx((first + second) / 2, rel=1e-3)
        assert densities.prior[row] == pytest.approx(survived + born, rel=1e-3)


def test_a_strip_that_shares_a_border_is_of_the_prior_too_whatever_its_width():
    states = states_at([-15.0, 0.0, 80.0, 0.0], [-15.0, 0.9, 80.0, 0.0])
    predicted = make_predicted(mass_switched=0.05, log_width=math.log(30.0), width_spread=0.3)
    shared, crossing = densities_at(predicted, states).prior
    switches = switch_density(states[0], SWITCH)
    assert shared == pytest.approx(0.05 * switches, rel=0.1)
    assert shared > 1e3 * crossing


def test_a_new_cable_of_another_width_is_less_likely_and_has_a_penalty_besides():
    states = states_at([100.0, 1.0, 30.0, 0.0], [100.0, 1.0, 90.0, 0.0])
    predicted = make_predicted(log_width=math.log(30.0), width_spread=0.3)
    found = densities_at(predicted, states)
    assert found.prior[0] > 7.0 * found.prior[1]
    assert found.width_penalties[0] == pytest.approx(0.0, abs=1e-9)
    assert found.width_penalties[1] < -math.log(7.0)
    without = densities_at(make_predicted(), states)
    assert without.prior[0] == pytest.approx(without.prior[1], rel=1e-3)
    assert (without.width_penalties == 0.0).all()


def test_a_pose_that_was_proposed_has_the_rates_of_its_likely_ancestor(rng):
    rates = rates_at(make_predicted(), states_at(*np.repeat(CENTRES, 50, axis=0)), rng)
    np.testing.assert_allclose(np.median(rates[:50], axis=0), RATES[0], atol=0.7)
    np.testing.assert_allclose(np.median(rates[50:], axis=0), RATES[1], atol=0.7)


def test_a_particle_beside_its_ancestor_has_the_rates_that_have_taken_it_there(rng):
    gains = (10.0, 2.0, 0.0, 0.0)
    beside = CENTRES[0] + [3.0, -0.02, 1.0, 0.0]
    rates = rates_at(make_predicted(rate_gains=gains), states_at(*[beside] * 100), rng)
    expected = RATES[0] + [30.0, -0.04, 0.0, 0.0]
    np.testing.assert_allclose(np.median(rates, axis=0), expected, atol=0.7)


def test_between_two_ancestors_the_likelier_one_is_chosen_more_often(rng):
    middle = CENTRES.mean(axis=0)
    rates = rates_at(make_predicted(mass_born=1e-12), states_at(*[middle] * 600), rng)
    assert (rates[:, 0] < 0.0).mean() == pytest.approx(0.9, abs=0.05)


def test_far_from_all_ancestors_it_has_the_rates_of_the_search(rng):
    predicted = make_predicted()
    rates = rates_at(predicted, states_at(*[[150.0, -1.2, 80.0, 0.1]] * 200), rng)
    lower, upper = predicted.births.box.lower[4:], predicted.births.box.upper[4:]
    assert ((rates >= lower) & (rates <= upper)).all(axis=1).mean() > 0.97
    assert np.ptp(rates[:, 0]) > 0.8 * (upper - lower)[0]
