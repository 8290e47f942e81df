from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.belief import initial_belief
from cable_tracker.cable.hypotheses.clusters import NO_CLUSTER, Clusters
from cable_tracker.cable.hypotheses.prediction import (
    SMALLEST_CLUSTER_SHARE,
    Ancestors,
    Predictor,
    draw_ancestors,
    surviving_ancestors,
    with_strips_in_birth_density,
)
from cable_tracker.cable.model.initial_state import search_box
from cable_tracker.cable.model.movement import CableMovement
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.particles import RESAMPLING_SCHEMES, Particles
from cable_tracker.tracking.rates import SurvivalRates

RATES = SurvivalRates(vanishing=0.25, leaving=10.0, margin=8.0)
SIZE = (320, 240)
GROUPS = (0, 1, NO_CLUSTER)
EACH_SCHEME = pytest.mark.parametrize("scheme", RESAMPLING_SCHEMES)


def sample(rng, count=60) -> tuple[Particles, Clusters]:
    """Two clusters, one of them light, and some particles of none; the place says which."""
    labels = np.repeat(GROUPS, count // 3)
    states = np.zeros((count, 8))
    states[:, 0] = labels * 50.0
    states[:, 2] = np.arange(count) + 1.0
    weights = rng.dirichlet(np.ones(count)) * np.repeat([9.0, 0.01, 1.0], count // 3)
    weights /= weights.sum()
    masses = np.array([weights[labels == label].sum() for label in (0, 1)])
    rest = weights[labels == NO_CLUSTER].sum()
    clusters = Clusters(labels, masses, np.zeros((2, 8)), rest)
    return Particles(states, np.log(weights)), clusters


def group_of(ancestors: Ancestors) -> np.ndarray:
    return np.rint(ancestors.states[:, 0] / 50.0).astype(int)


@EACH_SCHEME
def test_every_group_has_its_share_of_ancestors_and_its_weight(rng, scheme):
    particles, clusters = sample(rng)
    ancestors = draw_ancestors(particles, clusters, 6000, RESAMPLING_SCHEMES[scheme], rng)
    wanted = np.maximum([*clusters.masses, clusters.rest], SMALLEST_CLUSTER_SHARE)
    for label, share, mass in zip(
        GROUPS, wanted / wanted.sum(), (*clusters.masses, clusters.rest), strict=True
    ):
        members = group_of(ancestors) == label
        assert members.mean() == pytest.approx(share, abs=0.03)
        assert ancestors.weights[members].sum() == pytest.approx(mass, rel=0.3, abs=0.01)
    assert ancestors.weights.sum() == pytest.approx(1.0)


@EACH_SCHEME
def test_within_a_group_particles_are_drawn_by_their_weight(rng, scheme):
    particles, clusters = sample(rng)
    mean = np.average(particles.states[:20, 2], weights=particles.weights[:20])
    ancestors = draw_ancestors(particles, clusters, 6000, RESAMPLING_SCHEMES[scheme], rng)
    first = group_of(ancestors) == 0
    assert ancestors.states[first, 2].mean() == pytest.approx(mean, abs=0.4)


def test_a_group_that_weighs_nothing_has_no_ancestors(rng):
    particles, clusters = sample(rng)
    empty = clusters._replace(masses=np.array([clusters.masses[0], 0.0]))
    resample = RESAMPLING_SCHEMES["systematic"]
    ancestors = draw_ancestors(particles, empty, 6000, resample, rng)
    assert set(group_of(ancestors)) == {0, NO_CLUSTER}


def test_particles_near_the_edge_survive_less():
    states = np.zeros((40, 8))
    states[20:, 0] = 158.0
    before = Ancestors(states, np.full(40, 1 / 40))
    after, survival = surviving_ancestors(before, 0.0, SIZE, RATES, 0.5)
    assert after.weights[20:].sum() < 0.5 * after.weights[:20].sum()
    assert after.weights.sum() == pytest.approx(1.0)
    assert survival < np.exp(-0.25 * 0.5)
    assert surviving_ancestors(before, 0.0, SIZE, RATES, 0.0)[1] == pytest.approx(1.0)


def test_ancestors_are_written_in_the_chart_about_the_reference(rng):
    states = np.zeros((5, 8))
    states[:, 0], states[:, 1] = 20.0, 1.5
    before = Ancestors(states, np.full(5, 0.2))
    (after, _) = surviving_ancestors(before, -1.5, SIZE, RATES, 0.04)
    np.testing.assert_allclose(after.states[:, 0], -20.0)
    np.testing.assert_allclose(after.states[:, 1], 1.5 - np.pi)


@pytest.mark.parametrize(("dt", "time"), [(0.005, 0.005), (0.04, 0.04), (1.0, 1.0), (0.0, 0.04)])
def test_survivors_diffuse_and_frames_count_by_the_time_between_and_by_one_after_a_prior(
    dt, time, rng
):
    parameters = TrackerParameters()
    movement = CableMovement(parameters, SIZE[0])
    box = search_box(parameters, SIZE[0])
    belief = initial_belief(box.draw(50, rng), 0.9)
    prediction = Predictor(parameters, movement, box, SIZE, rng).predict(belief, dt, None)
    repeated = 1.0 - parameters.presence_gain
    assert prediction.prior.gain == pytest.approx(1.0 - repeated ** (25.0 * time))
    density, diffusion = prediction.density, movement.diffusion(time)
    np.testing.assert_allclose(density.kernels.scales, diffusion.pose_scales)
    np.testing.assert_allclose(density.rate_gains, diffusion.rate_gains)
    np.testing.assert_allclose(density.rate_scales, diffusion.rate_scales)


@pytest.mark.parametrize(("dt", "rated"), [(0.04, 0.04), (0.08, 0.08), (0.5, 0.08)])
def test_a_cable_is_expected_no_farther_than_rates_can_be_trusted(dt, rated, rng):
    parameters = TrackerParameters()
    movement = CableMovement(parameters, SIZE[0])
    predictor = Predictor(parameters, movement, search_box(parameters, SIZE[0]), SIZE, rng)
    belief = initial_belief(np.tile([10.0, 0.1, 30.0, 0.0, 60.0, 0.1, 0.0, 0.0], (50, 1)), 0.9)
    expected = predictor.predict(belief, dt, None).prior.expected
    means = belief.hypotheses.clusters.means
    np.testing.assert_allclose(expected[:, :4], movement.expected(means, rated)[:, :4])


def test_strips_of_a_map_stand_in_the_chart_of_the_particles(rng):
    parameters = TrackerParameters()
    movement = CableMovement(parameters, 320)
    predictor = Predictor(parameters, movement, search_box(parameters, 320), SIZE, rng)
    states = search_box(parameters, 320).draw(50, rng)
    prediction = predictor.predict(initial_belief(states, 0.5), 0.04, None)
    prediction = prediction._replace(reference_angle=-1.5)
    shown = np.array([[-60.0, np.pi / 2, 40.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    births = with_strips_in_birth_density(prediction, shown).density.births
    np.testing.assert_allclose(births.map_strips[0, :4], [60.0, -np.pi / 2, 40.0, 0.0])
    assert prediction.density.births.map_strips.shape == (0, 8)
