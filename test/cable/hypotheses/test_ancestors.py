from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.ancestors import (
    SMALLEST_CLUSTER_SHARE,
    plan_draw,
    surviving_ancestors,
)
from cable_tracker.cable.hypotheses.clusters import NONE, Clusters
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.tracking.survival import SurvivalRates

RATES = SurvivalRates(vanishing=0.25, leaving=10.0, margin=8.0)
SIZE = (320.0, 240.0)
EACH_SCHEME = pytest.mark.parametrize("scheme", RESAMPLING_SCHEMES)


def sample(rng, count=60) -> tuple[np.ndarray, np.ndarray, Clusters]:
    """Two clusters, one of them light, and some particles of none; the place says which."""
    labels = np.repeat([0, 1, NONE], count // 3)
    states = np.zeros((count, 8))
    states[:, 0] = labels * 50.0
    states[:, 2] = np.arange(count) + 1.0
    weights = rng.dirichlet(np.ones(count)) * np.repeat([9.0, 0.1, 1.0], count // 3)
    weights /= weights.sum()
    masses = np.array([weights[labels == label].sum() for label in (0, 1)])
    rest = weights[labels == NONE].sum()
    return states, weights, Clusters(labels, masses, np.zeros((2, 8)), rest)


def drawn(rng, scheme, count=40, dt=0.0):
    states, weights, clusters = sample(rng)
    draw = plan_draw(np.log(weights), clusters, count, scheme, rng)
    ancestors, target, survival = surviving_ancestors(
        states, np.log(weights), clusters.labels, draw, 0.0, SIZE, RATES, dt
    )
    return weights, clusters, draw, ancestors, target, survival


@EACH_SCHEME
def test_every_group_has_ancestors_and_its_whole_weight(rng, scheme):
    _, clusters, draw, ancestors, target, survival = drawn(rng, scheme)
    assert draw.counts.min() >= int(SMALLEST_CLUSTER_SHARE * 40) - 1
    groups = np.rint(ancestors[:, 0] / 50.0).astype(int)
    for label, mass in ((0, clusters.masses[0]), (1, clusters.masses[1]), (NONE, clusters.rest)):
        assert target[groups == label].sum() == pytest.approx(mass)
    assert survival == pytest.approx(1.0)


@EACH_SCHEME
def test_within_a_group_particles_are_drawn_by_their_weight(rng, scheme):
    states, weights, clusters = sample(rng)
    mean = np.average(states[:20, 2], weights=weights[:20])
    draw = plan_draw(np.log(weights), clusters, 6000, scheme, rng)
    ancestors, _, _ = surviving_ancestors(
        states, np.log(weights), clusters.labels, draw, 0.0, SIZE, RATES, 0.0
    )
    assert ancestors[ancestors[:, 0] == 0.0, 2].mean() == pytest.approx(mean, abs=0.3)


def test_who_is_nearer_to_the_edge_survives_less(rng):
    states, weights, clusters = sample(rng)
    states[:20, 0], states[20:40, 0] = 158.0, 0.0
    clusters = clusters._replace(masses=np.array([0.5, 0.5]), rest=0.0)
    weights = np.repeat([0.5 / 20, 0.5 / 20, 1e-300], 20)
    draw = plan_draw(np.log(weights), clusters, 40, "systematic", rng)
    ancestors, target, survival = surviving_ancestors(
        states, np.log(weights), clusters.labels, draw, 0.0, SIZE, RATES, 0.5
    )
    edge = ancestors[:, 0] > 100.0
    assert target[edge].sum() < 0.5 * target[~edge].sum()
    assert survival < np.exp(-0.25 * 0.5)
