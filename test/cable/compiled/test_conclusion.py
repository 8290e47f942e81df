from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.clusters import MOST_CLUSTERS, clusters_of, find_groups
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import MultiHypothesisFilter
from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio, bright_shares
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

pytest.importorskip("numba")

from cable_tracker.cable.compiled.conclusion import conclude
from cable_tracker.cable.compiled.likelihood_ratio import CompiledLikelihoodRatio
from cable_tracker.cable.compiled.mixture_sample import Balance
from cable_tracker.cable.compiled.multi_hypothesis_filter import CompiledMultiHypothesisFilter
from cable_tracker.cable.compiled.rounds import Sample, empty_sample

WIDTH = 320
NO_ANCHOR = np.empty((0, 8))
AS_IT_IS = Balance(evidence_of_bottom=0.0, evidence_limit=1e9, evidence_repeated=1.0)
RULES = Balance(evidence_of_bottom=1.0, evidence_limit=4.0, evidence_repeated=0.2)


def any_sample(rng, count=60, groups=3) -> Sample:
    """A few clouds, one across the wrap, some particles impossible; more rows than are drawn."""
    sample = empty_sample(count + 5)
    centres = rng.uniform(-1, 1, (groups, 8)) * np.array([150, 1.5, 20, 0.1, 9, 1, 9, 1])
    centres[:, 2] += 40.0
    centres[0, 1] = np.pi / 2
    spread = np.array([6.0, 0.06, 6.0, 0.04, 1.0, 0.1, 1.0, 0.1])
    rows = rng.integers(0, groups, count + 5)
    sample.states[:] = centres[rows] + rng.standard_normal((count + 5, 8)) * spread
    sample.densities.full[:] = rng.uniform(0.1, 1.0, count + 5)
    sample.densities.survived[:] = sample.densities.full * rng.random(count + 5)
    sample.densities.width_factors[:] = -rng.random(count + 5)
    sample.mixture[:] = rng.uniform(10.0, 90.0, count + 5)
    sample.ratios[:] = rng.uniform(-3, 6, count + 5)
    sample.ratios[rng.random(count + 5) < 0.1] = -np.inf
    sample.ratios[0] = 5.0
    for field in sample.evidence:
        field[:] = rng.normal(0, 3, field.shape)
    return sample


def log_posterior(sample, count) -> np.ndarray:
    prior = np.log(sample.densities.full[:count] / sample.mixture[:count])
    return prior + sample.ratios[:count]


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_evidence_as_it_is_gives_the_clusters_of_the_posterior(seed, anchored):
    sample = any_sample(np.random.default_rng(seed))
    states, posterior = wrap_states(sample.states[:60]), log_posterior(sample, 60)
    anchor = states[1] if anchored else None
    groups = find_groups(states, posterior, WIDTH, anchor)
    weights = np.exp(posterior - np.logaddexp.reduce(posterior))
    expected = clusters_of(groups, states, weights)
    anchors = NO_ANCHOR if anchor is None else anchor[None]
    found = conclude(sample, 60, float(WIDTH), anchors, AS_IT_IS, 0.6)
    assert found.log_evidence == pytest.approx(np.logaddexp.reduce(posterior))
    np.testing.assert_allclose(np.exp(found.log_weights), weights, rtol=1e-9)
    np.testing.assert_allclose(found.states, states, atol=1e-9)
    np.testing.assert_array_equal(found.members, [cluster.members for cluster in expected])
    np.testing.assert_allclose(found.masses, [cluster.mass for cluster in expected])
    np.testing.assert_allclose(found.means, [cluster.mean for cluster in expected], atol=1e-9)
    shares = bright_shares(sample.evidence.log_ratios[:60], 0.6)
    assert found.brightness == pytest.approx(weights @ shares)
    within = weights * found.members[0] / found.masses[0]
    assert found.seen == pytest.approx(within @ sample.evidence.seen[:60])


@given(st.integers(0, 2**32 - 1))
def test_whatever_is_concluded_is_sound(seed):
    sample = any_sample(np.random.default_rng(seed))
    found = conclude(sample, 60, float(WIDTH), NO_ANCHOR, RULES, 0.5)
    weights = np.exp(found.log_weights)
    assert weights.sum() == pytest.approx(1.0)
    assert (np.diff(found.masses) <= 0.0).all()
    assert (found.members.sum(axis=0) <= 1).all()
    np.testing.assert_allclose(found.members @ weights, found.masses)
    assert 0.0 <= found.brightness <= 1.0


def test_of_nothing_that_is_possible_no_cluster_is_concluded(rng):
    sample = any_sample(rng)
    sample.ratios[:] = -np.inf
    found = conclude(sample, 60, float(WIDTH), NO_ANCHOR, RULES, 0.5)
    assert found.log_evidence == -math.inf
    assert len(found.masses) == len(found.means) == len(found.members) == 0


def test_where_all_groups_become_light_the_rest_is_grouped_anew(rng):
    # One particle each, far from one another; one more than groups have names.
    count = MOST_CLUSTERS + 1
    sample = any_sample(rng, count)
    sample.states[:] = 0.0
    sample.states[:, 0] = 100.0 * np.arange(count + 5)
    sample.states[:, 2] = 30.0
    sample.densities.full[:], sample.mixture[:] = 1.0, 1.0
    sample.densities.survived[:] = 0.0
    # The last is the least likely, but of the usual width.
    sample.ratios[:], sample.densities.width_factors[:] = 10.0, -100.0
    sample.ratios[count - 1], sample.densities.width_factors[count - 1] = 5.0, 0.0
    found = conclude(sample, count, float(WIDTH), NO_ANCHOR, RULES, 0.5)
    np.testing.assert_allclose(found.masses, [1.0])
    assert np.flatnonzero(found.members[0]).tolist() == [count - 1]


SIZE = (160, 120)
STRIP = CableState(12.0, 0.2, 24.0, 0.03)


@pytest.mark.parametrize("cable", [STRIP, CableState(5.0, np.pi / 2, 24.0, 0.03)], ids=str)
@pytest.mark.parametrize("presence", ["given", "none"])
@pytest.mark.parametrize("seed", range(2))
def test_a_step_of_both_filters_concludes_the_same(
    cable, presence, seed, draw_strip, noise_picture
):
    values = TrackerParameters(particle_count=300)
    picture = draw_strip(cable, SIZE, strip=130.0, ground=100.0, blur=2.0).astype(np.float32)
    image = make_working_image(picture + noise_picture(seed, SIZE, 4.0) - np.float32(110.0), 320)
    plain, compiled = (
        kind(values, ratio(values), SIZE, np.random.default_rng(seed))
        for kind, ratio in (
            (MultiHypothesisFilter, BorderLikelihoodRatio),
            (CompiledMultiHypothesisFilter, CompiledLikelihoodRatio),
        )
    )
    about = np.random.default_rng(seed).standard_normal((300, 8))
    near = cable.to_array() + about * [2, 0.03, 2, 0.02, 5, 0.05, 2, 0.02]
    given = plain.belief_given(near)
    before = (
        given
        if presence == "given"
        else MultiHypothesisFilter(
            values, BorderLikelihoodRatio(values), SIZE, np.random.default_rng(9)
        ).first_belief()
    )
    seen = cable.to_array()[None, :4]
    expected, found = (each.step(before, image, 0.04, seen) for each in (plain, compiled))
    assert found.presence == pytest.approx(expected.presence, abs=1e-5)
    assert found.bright == pytest.approx(expected.bright, abs=1e-5)
    assert found.evidence == pytest.approx(expected.evidence, abs=1e-4)
    assert found.seen == pytest.approx(expected.seen, abs=1e-4)
    for one, other in zip(found.clusters, expected.clusters, strict=True):
        np.testing.assert_array_equal(one.members, other.members)
        assert one.mass == pytest.approx(other.mass, abs=1e-4)
        np.testing.assert_allclose(one.mean, other.mean, atol=1e-3)
