from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.frame_noise import draw_frame_noise
from cable_tracker.cable.hypotheses.leaving import BirthDensity, RememberedCable
from cable_tracker.cable.hypotheses.prior_density import Prior
from cable_tracker.cable.hypotheses.usual_width import UsualWidth
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.initialisation import search_box
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import PredictedExistence
from cable_tracker.particle_filter.kernel_mixture import KernelMixture

pytest.importorskip("numba")

from cable_tracker.cable.compiled.prior_density import (
    birth_density,
    choose_rates,
    empty_densities,
    log_width_factor,
    prior_arrays,
    weigh_by_prior,
)

SIZE = (320, 240)
SEEDS = st.integers(0, 2**32 - 1)
TAILS = st.sampled_from([4.0, 1.0, 30.0, math.inf])
MEMORIES = {
    "none": None,
    "in the middle": RememberedCable(np.array([20.0, 0.3, 30.0, 0.0]), 0.0, 0.1),
    "left by a side": RememberedCable(np.array([150.0, 0.1, 30.0, 0.02]), 1.0, 0.5),
    "left by the other": RememberedCable(np.array([-150.0, -0.1, 30.0, 0.0]), -1.0, 5.0),
    "beside the wrap": RememberedCable(np.array([20.0, np.pi / 2 - 0.01, 30.0, 0.0]), 0.0, 0.1),
    "forgotten": RememberedCable(np.array([20.0, 0.3, 30.0, 0.0]), 0.0, 1e4),
}
SMALLEST = 1e-290
"""Below it, logarithms go on where numbers end."""

SMALLEST_KERNEL = 1e-36
"""The same for kernels, which are of single precision."""

SINGLE = 1e-4
"""Relative: two places that are 200 scales apart, rounded to single precision, where a kernel of
Student-t changes fastest."""

SINGLE_GAUSSIAN = 1e-3
"""The same where a Gaussian is still a number."""


def any_states(rng, count, reference=0.0) -> np.ndarray:
    states = rng.uniform(-1, 1, (count, 8)) * np.array([180, 1.57, 0, 0.2, 50, 1, 20, 1])
    states[:, 2] = rng.uniform(1, 130, count)
    return unwrap_states(states, reference)


def any_prior(rng, tail=4.0, memory=None, ancestors=30, usual=True, existence=(0.8, 0.1)) -> Prior:
    parameters = TrackerParameters()
    reference = float(rng.uniform(-1.5, 1.5))
    centres = any_states(rng, ancestors, reference)
    return Prior(
        kernels=KernelMixture(centres[:, :4], np.array([2.0, 0.03, 2.0, 0.02]), tail),
        target=rng.dirichlet(np.ones(ancestors)),
        proposal=np.full(ancestors, 1.0 / ancestors),
        rates=centres[:, 4:],
        rate_sigmas=np.array([3.0, 0.1, 2.0, 0.1]),
        births=BirthDensity(search_box(parameters, SIZE[0]), memory, 4.0, SIZE),
        existence=PredictedExistence(*existence),
        reference_angle=reference,
        usual_width=UsualWidth(math.log(30.0), 0.3) if usual else None,
        parameters=parameters,
        leader_shift=np.zeros(4),
    )


def near_and_far(rng, prior, count=40) -> np.ndarray:
    """Half of the states about ancestors, half anywhere."""
    far = any_states(rng, count // 2, prior.reference_angle)
    about = rng.integers(0, len(prior.target), count // 2)
    noise = draw_frame_noise(rng, len(about), 0, prior.kernels.degrees_of_freedom)
    places = prior.kernels.placed_about(about, noise.of_places(slice(None)))
    near = np.hstack((places, prior.rates[about]))
    return unwrap_states(np.concatenate((near, far)), prior.reference_angle)


@given(SEEDS, TAILS, st.sampled_from(sorted(MEMORIES)), st.booleans())
def test_densities_are_the_same(seed, tail, memory, usual):
    rng = np.random.default_rng(seed)
    prior = any_prior(rng, tail, MEMORIES[memory], usual=usual)
    states = near_and_far(rng, prior)
    expected = prior.log_densities(states)
    found = empty_densities(len(states))
    weigh_by_prior(states, 0, len(states), prior_arrays(prior), found)
    single = SINGLE_GAUSSIAN if math.isinf(tail) else SINGLE
    for name in ("full", "survived", "survivors"):
        densities = np.exp(getattr(expected, name))
        np.testing.assert_allclose(
            getattr(found, name), densities, rtol=single, atol=SMALLEST_KERNEL, err_msg=name
        )
    np.testing.assert_allclose(found.births, np.exp(expected.births), rtol=1e-6, atol=SMALLEST)
    np.testing.assert_allclose(
        found.width_factors, prior.log_width_factors(states), rtol=1e-9, atol=1e-12
    )


@pytest.mark.parametrize("existence", [(0.0, 0.5), (0.5, 0.0), (1.0, 0.0)])
def test_nothing_may_be_born_or_survive(existence, rng):
    prior = any_prior(rng, existence=existence)
    states = near_and_far(rng, prior)
    found = empty_densities(len(states))
    weigh_by_prior(states, 0, len(states), prior_arrays(prior), found)
    np.testing.assert_allclose(np.log(found.full), prior.log_densities(states).full, atol=SINGLE)


@given(SEEDS, TAILS, st.sampled_from(sorted(MEMORIES)), st.integers(1, 40))
def test_the_same_random_numbers_give_the_same_rates(seed, tail, memory, ancestors):
    rng = np.random.default_rng(seed)
    prior = any_prior(rng, tail, MEMORIES[memory], ancestors)
    states = near_and_far(rng, prior)
    count = len(states)
    noise = draw_frame_noise(np.random.default_rng(seed), count, 0, tail)
    sooner, expected, later = (
        prior.rates_from(
            states, noise.uniform * [1.0 + change, *[1.0] * 7], noise.of_rates(slice(None))
        )
        for change in (-SINGLE_GAUSSIAN, 0.0, SINGLE_GAUSSIAN)
    )
    # Next to the edge of an ancestor's share rounding says whose child it is.
    certain = ((sooner == expected) & (expected == later)).all(axis=1)
    assert certain.mean() > 0.8
    found, densities = states.copy(), empty_densities(count)
    choose_rates(found, 0, count, prior_arrays(prior), densities, noise)
    np.testing.assert_array_equal(found[:, :4], states[:, :4])
    # Where the prior is too small for numbers, the particle weighs nothing, whatever its rates.
    checked = certain & (densities.full > SMALLEST_KERNEL)
    np.testing.assert_allclose(found[checked, 4:], expected[checked], rtol=1e-9, atol=1e-9)
    weighed = empty_densities(count)
    weigh_by_prior(states, 0, count, prior_arrays(prior), weighed)
    np.testing.assert_array_equal(densities.full, weighed.full)


@given(SEEDS, st.sampled_from(sorted(MEMORIES)))
def test_births_are_as_dense_however_the_line_is_written(seed, memory):
    rng = np.random.default_rng(seed)
    prior = any_prior(rng, memory=MEMORIES[memory])
    arrays = prior_arrays(prior).births
    for state in any_states(rng, 10):
        turned = state * np.array([-1, 1, 1, -1, -1, 1, 1, -1]) + np.pi * np.eye(8)[1]
        expected = float(np.exp(prior.births.log_density(state[None])[0]))
        assert birth_density(state, arrays) == pytest.approx(expected, rel=1e-9)
        assert birth_density(turned, arrays) == pytest.approx(expected, rel=1e-6)


def test_a_width_says_nothing_where_none_is_usual():
    assert log_width_factor(90.0, 0.0, math.inf) == 0.0
    assert log_width_factor(0.0, 3.0, 0.3) < -1.0
