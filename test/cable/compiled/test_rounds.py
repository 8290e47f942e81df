from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.frame_noise import draw_frame_noise
from cable_tracker.cable.hypotheses.leaving import BirthDensity, RememberedCable
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import MultiHypothesisFilter
from cable_tracker.cable.hypotheses.prior_density import Prior
from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.initialisation import search_box
from cable_tracker.cable.model.movement import state_limits
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import PredictedExistence
from cable_tracker.particle_filter.kernel_mixture import KernelMixture

pytest.importorskip("numba")

from cable_tracker.cable.compiled.likelihood_ratio import CompiledLikelihoodRatio
from cable_tracker.cable.compiled.multi_hypothesis_filter import CompiledMultiHypothesisFilter
from cable_tracker.cable.compiled.prior_density import prior_arrays
from cable_tracker.cable.compiled.rounds import Frame, Plan, Rules, draw_sample, empty_sample

SIZE = (160, 120)
STRIP = CableState(12.0, 0.2, 24.0, 0.03)
SEEDS = st.integers(0, 2**32 - 1)
TAILS = st.sampled_from([4.0, 1.0, math.inf])
DETECTION_SIGMAS = np.array([3.0, 0.03, 4.0, 0.03])
PARAMETERS = TrackerParameters()
LOOK = CompiledLikelihoodRatio(PARAMETERS).look(
    make_working_image(np.random.default_rng(7).normal(110, 8, SIZE[::-1]).astype(np.float32), 320)
)


def any_prior(rng, tail) -> Prior:
    centres = STRIP.to_array() + rng.standard_normal((12, 8)) * [4, 0.05, 3, 0.02, 5, 0.1, 1, 0.1]
    memory = RememberedCable(STRIP.to_array()[:4], 0.0, 0.2)
    return Prior(
        kernels=KernelMixture(centres[:, :4], np.array([2.0, 0.03, 2.0, 0.02]), tail),
        target=rng.dirichlet(np.ones(12)),
        proposal=np.full(12, 1.0 / 12),
        rates=centres[:, 4:],
        rate_sigmas=np.array([3.0, 0.1, 2.0, 0.1]),
        births=BirthDensity(search_box(PARAMETERS, SIZE[0]), memory, 4.0, SIZE),
        existence=PredictedExistence(0.8, 0.1),
        reference_angle=STRIP.angle,
        usual_width=None,
        parameters=PARAMETERS,
        leader_shift=np.zeros(4),
    )


def rules(tail=4.0, rounds=2, lowest=-math.inf) -> Rules:
    limits = state_limits(PARAMETERS, SIZE[0])
    return Rules(
        image_width=float(SIZE[0]),
        degrees_of_freedom=tail,
        lower=np.maximum(limits.lower, lowest),
        upper=limits.upper,
        detection_sigmas=DETECTION_SIGMAS,
        smallest_sigmas=0.05 * DETECTION_SIGMAS,
        powers=np.linspace(0.3, 1.0, rounds),
        widenings=np.full(rounds, 1.2),
        most_refined=3,
        smallest_refined=0.02,
    )


def plan_of(prior, counts, refined) -> Plan:
    survivors, births, detections = counts
    return Plan(
        survivors, births, prior.births.remembered_of(births), detections,
        np.array(refined, np.int64),
    )  # fmt: skip


def frame_of(rng, prior, plan, detections=2) -> Frame:
    count = plan.survivors + plan.births + plan.detections + int(plan.refined.sum())
    places = STRIP.to_array()[:4] + rng.standard_normal((detections, 4)) * DETECTION_SIGMAS
    return Frame(
        prior=prior_arrays(prior),
        noise=draw_frame_noise(rng, count, plan.births, prior.kernels.degrees_of_freedom),
        look=LOOK,
        bright=0.5,
        reference_angle=prior.reference_angle,
        ancestors=rng.integers(0, len(prior.target), plan.survivors),
        detected=places,
    )


@given(SEEDS, TAILS, st.tuples(st.integers(0, 20), st.integers(0, 20), st.integers(0, 20)))
def test_the_first_particles_are_those_of_their_proposals(seed, tail, counts):
    rng = np.random.default_rng(seed)
    prior = any_prior(rng, tail)
    plan = plan_of(prior, counts, ())
    frame = frame_of(rng, prior, plan)
    sample = empty_sample(sum(counts))
    assert draw_sample(sample, frame, plan, rules(tail, 0)) == sum(counts)
    survivors, births, found = np.split(sample.states, np.cumsum(counts)[:-1])
    noise, rows = frame.noise, slice(0, plan.survivors)
    moved = np.hstack(
        (
            prior.kernels.placed_about(frame.ancestors, noise.of_places(rows)),
            prior.rates_about(frame.ancestors, noise.of_rates(rows)),
        )
    )
    born = prior.births.placed(
        noise.uniform[rows.stop : rows.stop + plan.births], noise.about_memory
    )
    for states, drawn in ((survivors, moved), (births, born)):
        expected = unwrap_states(drawn, prior.reference_angle)
        np.testing.assert_allclose(states, expected, rtol=1e-9, atol=1e-9)
    about = frame.detected[np.arange(plan.detections) % len(frame.detected)]
    noise_there = noise.of_places(slice(rows.stop + plan.births, None))
    expected = np.zeros_like(found)
    expected[:, :4] = about + noise_there * DETECTION_SIGMAS
    expected = unwrap_states(expected, prior.reference_angle)
    np.testing.assert_allclose(found[:, :4], expected[:, :4], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("refined", [(), (0,), (30,), (20, 30), (0, 25), (10, 10, 10)])
def test_every_round_draws_what_is_planned_and_all_that_is_drawn_is_looked_at(refined, rng):
    prior = any_prior(rng, 4.0)
    plan = plan_of(prior, (30, 10, 10), refined)
    sample = empty_sample(100)
    for field in (sample.states, sample.ratios, sample.mixture, sample.densities.full):
        field[:] = np.nan
    filled = draw_sample(sample, frame_of(rng, prior, plan), plan, rules(rounds=len(refined)))
    assert filled == 50 + sum(refined)
    assert np.isfinite(sample.states[:filled]).all()
    assert (sample.densities.full[:filled] > 0.0).all()
    assert (sample.mixture[:filled] > 0.0).all()
    assert not np.isnan(sample.ratios[:filled]).any()
    assert np.isnan(sample.states[filled:]).all()


def test_no_round_draws_about_what_is_impossible(rng):
    prior = any_prior(rng, 4.0)
    plan = plan_of(prior, (30, 10, 10), (20, 30))
    sample = empty_sample(100)
    assert draw_sample(sample, frame_of(rng, prior, plan), plan, rules(lowest=1e6)) == 50
    np.testing.assert_array_equal(sample.ratios[:50], -np.inf)


def test_what_was_drawn_before_leaves_no_trace(rng):
    prior = any_prior(rng, 4.0)
    plan = plan_of(prior, (30, 10, 10), (20, 30))
    first, second = (frame_of(rng, prior, plan) for _ in range(2))
    used, fresh = empty_sample(100), empty_sample(100)
    draw_sample(used, first, plan, rules())
    draw_sample(used, second, plan, rules())
    draw_sample(fresh, second, plan, rules())
    np.testing.assert_array_equal(used.states, fresh.states)
    np.testing.assert_array_equal(used.ratios, fresh.ratios)
    np.testing.assert_array_equal(used.mixture, fresh.mixture)


@pytest.mark.parametrize("rounds", range(5))
@pytest.mark.parametrize("detections", [0, 1, 3])
def test_a_step_of_both_filters_draws_and_weighs_the_same_particles(
    rounds, detections, draw_strip, noise_picture
):
    values = PARAMETERS.replaced({"particle_count": 300, "refinement_rounds": rounds})
    picture = draw_strip(STRIP, SIZE, strip=130.0, ground=100.0, blur=2.0).astype(np.float32)
    image = make_working_image(picture + noise_picture(1, SIZE, 4.0) - np.float32(110.0), 320)
    plain, compiled = (
        kind(values, ratio(values), SIZE, np.random.default_rng(rounds))
        for kind, ratio in (
            (MultiHypothesisFilter, BorderLikelihoodRatio),
            (CompiledMultiHypothesisFilter, CompiledLikelihoodRatio),
        )
    )
    rng = np.random.default_rng(detections)
    before = plain.belief_given(STRIP.to_array() + rng.standard_normal((300, 8)) * 0.02)
    places = STRIP.to_array()[:4] + rng.standard_normal((detections, 4)) * DETECTION_SIGMAS
    expected, found = (each.step(before, image, 0.04, places) for each in (plain, compiled))
    np.testing.assert_allclose(
        found.particles.states, expected.particles.states, rtol=1e-5, atol=1e-5
    )
    np.testing.assert_allclose(found.particles.weights, expected.particles.weights, atol=1e-4)
