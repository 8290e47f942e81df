from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses import clusters as kernels
from cable_tracker.cable.hypotheses.clusters import MOST_CLUSTERS, NO_CLUSTER, RADII, Groups
from cable_tracker.cable.model.geometry import states_in_chart, wrap_state, wrap_states
from cable_tracker.cable.model.state import pose_units

WIDTH = 320
NOWHERE = np.empty((0, 8))
SIGMA = np.array([2.0, 0.01, 2.0, 0.01, 1.0, 0.1, 1.0, 0.1])


def cloud(rng, distance, angle, count=100, width=30.0) -> np.ndarray:
    middle = np.array([distance, angle, width, 0.0, 0.0, 0.0, 0.0, 0.0])
    return wrap_states(middle + rng.standard_normal((count, 8)) * SIGMA)


class Found(NamedTuple):
    mass: float
    mean: np.ndarray
    members: np.ndarray

    @property
    def state(self) -> np.ndarray:
        return wrap_state(self.mean)


def named(clusters) -> list[Found]:
    return [
        Found(mass, mean, clusters.labels == index)
        for index, (mass, mean) in enumerate(zip(clusters.masses, clusters.means, strict=True))
    ]


def groups_of(
    states, log_weights, width, anchors=NOWHERE, most=MOST_CLUSTERS, least=-np.inf
) -> Groups:
    radii = RADII * pose_units(width / 320)
    return kernels.find_groups(states, log_weights, radii, most, least, anchors)


def grouped(states, weights, width):
    with np.errstate(divide="ignore"):
        groups = groups_of(states, np.log(weights), width)
    return kernels.clusters_of(states, weights, groups)[0]


def find_clusters(states, weights, width) -> list[Found]:
    return named(grouped(states, weights, width))


def spread_of_leader(states, weights, width) -> np.ndarray:
    clusters = grouped(states, weights, width)
    covariance = kernels.group_covariance(
        states, weights, clusters.labels, 0, clusters.masses[0], clusters.means[0]
    )
    return np.sqrt(np.diag(covariance))


def find_groups(states, log_weights, width, anchor=None) -> list[np.ndarray]:
    anchors = NOWHERE if anchor is None else anchor[None, :]
    groups = groups_of(states, log_weights, width, anchors)
    return [groups.labels == group for group in range(groups.number)]


def equal(count) -> np.ndarray:
    return np.full(count, 1.0 / count)


@pytest.mark.parametrize("angle", [0.2, np.pi / 2, -np.pi / 2 + 0.005])
def test_two_separate_clouds_are_two_clusters_and_no_mean_lies_between(angle, rng):
    states = np.concatenate((cloud(rng, -60.0, angle, 60), cloud(rng, 60.0, angle, 40)))
    first, second = find_clusters(states, equal(100), WIDTH)
    assert first.members.tolist() == [True] * 60 + [False] * 40
    assert second.members.tolist() == [False] * 60 + [True] * 40
    assert (first.mass, second.mass) == pytest.approx((0.6, 0.4))
    for cluster, distance in ((first, -60.0), (second, 60.0)):
        chart = states_in_chart(cluster.state[None, :], angle)[0]
        assert chart[0] == pytest.approx(distance, abs=2.0)
        assert chart[1] == pytest.approx(angle, abs=0.01)
        assert -np.pi / 2 < cluster.state[1] <= np.pi / 2


def test_a_cloud_on_both_sides_of_the_wrap_is_one_cluster(rng):
    states = cloud(rng, 20.0, np.pi / 2)
    assert {-1.0, 1.0} == set(np.sign(states[:, 0]))
    (cluster,) = find_clusters(states, equal(100), WIDTH)
    assert cluster.mass == pytest.approx(1.0)
    spread = spread_of_leader(states, equal(100), WIDTH)
    np.testing.assert_allclose(spread, SIGMA, rtol=0.4)


def test_cables_of_other_widths_are_other_clusters(rng):
    states = np.concatenate((cloud(rng, 0.0, 0.0, width=20.0), cloud(rng, 0.0, 0.0, width=90.0)))
    assert len(find_clusters(states, equal(200), WIDTH)) == 2


def test_the_leading_cluster_has_the_greatest_mass_not_the_heaviest_particle(rng):
    states = np.concatenate((cloud(rng, -60.0, 0.0, 1), cloud(rng, 60.0, 0.0, 99)))
    weights = np.concatenate(([0.1], np.full(99, 0.9 / 99)))
    leader = find_clusters(states, weights, WIDTH)[0]
    assert leader.mean[0] == pytest.approx(60.0, abs=2.0)


@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_every_particle_is_in_one_cluster_at_most(seed, count):
    rng = np.random.default_rng(seed)
    states = rng.uniform(-1, 1, (count, 8)) * np.array([190, np.pi / 2, 0, 0.1, 1, 1, 1, 1])
    states[:, 2] = rng.uniform(5, 120, count)
    weights = rng.dirichlet(np.full(count, 0.3))
    clusters = find_clusters(wrap_states(states), weights, WIDTH)
    assert 1 <= len(clusters) <= MOST_CLUSTERS
    assert np.sum([cluster.members for cluster in clusters], axis=0).max() == 1
    masses = [cluster.mass for cluster in clusters]
    assert masses == sorted(masses, reverse=True)
    assert sum(masses) <= 1.0 + 1e-9
    for cluster in clusters:
        assert cluster.mass == pytest.approx(weights[cluster.members].sum())
        assert np.isfinite(cluster.mean).all()


def test_particles_without_weight_belong_to_none(rng):
    states = np.concatenate((cloud(rng, -60.0, 0.0, 50), cloud(rng, 60.0, 0.0, 50)))
    weights = np.concatenate((np.full(50, 1 / 50), np.zeros(50)))
    (cluster,) = find_clusters(states, weights, WIDTH)
    assert not cluster.members[50:].any()
    assert find_groups(states, np.full(100, -np.inf), WIDTH) == []


def test_the_lightest_cloud_gathers_too(rng):
    states = np.concatenate((cloud(rng, -60.0, 0.0, 50), cloud(rng, 60.0, 0.0, 50)))
    groups = find_groups(states, np.repeat([0.0, -2000.0], 50), WIDTH)
    assert [group.sum() for group in groups] == [50, 50]
    # It has no weight in numbers, so that it is no cluster.
    labels, weights = np.repeat([0, 1], 50), np.repeat([1 / 50, 0.0], 50)
    clusters, _ = kernels.clusters_of(states, weights, Groups(labels, 2))
    assert clusters.labels.tolist() == [0] * 50 + [NO_CLUSTER] * 50


def test_no_group_is_found_about_a_particle_that_is_too_light(rng):
    states = np.concatenate((cloud(rng, -60.0, 0.0, 50), cloud(rng, 60.0, 0.0, 50)))
    log_weights = np.repeat([0.0, -50.0], 50)
    groups = groups_of(states, log_weights, WIDTH, least=-50.0)
    assert groups.labels.tolist() == [0] * 50 + [NO_CLUSTER] * 50
    assert groups_of(states, log_weights, WIDTH, least=-51.0).number == 2


def test_the_first_group_is_at_the_anchor_however_light(rng):
    states = np.concatenate((cloud(rng, -60.0, 0.0, 50), cloud(rng, 60.0, 0.0, 50)))
    log_weights = np.repeat([0.0, -50.0], 50)
    anchor = np.array([62.0, 0.0, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    anchored, free = find_groups(states, log_weights, WIDTH, anchor)
    assert anchored[50:].all()
    assert free[:50].all()
    beyond = anchor + np.array([90.0, *[0.0] * 7])
    assert find_groups(states, log_weights, WIDTH, beyond)[0][:50].all()


def test_lengths_scale_with_the_image():
    states = np.zeros((2, 8))
    states[:, 2] = 30.0
    states[1, 0] = RADII[0] * 1.5
    assert len(find_clusters(states, equal(2), 320)) == 2
    assert len(find_clusters(states, equal(2), 640)) == 1


def test_one_particle_is_one_cluster_without_a_spread(rng):
    states = cloud(rng, 5.0, 0.1, 1)
    (cluster,) = find_clusters(states, np.ones(1), WIDTH)
    np.testing.assert_allclose(cluster.state, states[0])
    np.testing.assert_allclose(spread_of_leader(states, np.ones(1), WIDTH), 0.0)


def test_clusters_know_which_groups_they_were(rng):
    states = np.concatenate((cloud(rng, -60.0, 0.0, 30), cloud(rng, 60.0, 0.0, 70)))
    groups = Groups(np.repeat([0, 1], [30, 70]), 2)
    clusters, order = kernels.clusters_of(states, equal(100), groups)
    assert order.tolist() == [1, 0]
    assert clusters.labels.tolist() == [1] * 30 + [0] * 70


def test_the_most_probable_cable_leads_not_the_heaviest_cluster():
    masses, log_odds = np.array([0.7, 0.2, 0.1]), np.array([-4.0, 4.0, -6.0])
    assert kernels.most_probable_first(masses, log_odds).tolist() == [1, 0, 2]


def test_equally_probable_clusters_keep_their_order():
    masses, log_odds = np.array([0.5, 0.5]), np.array([5.0, 5.0])
    assert kernels.most_probable_first(masses, log_odds).tolist() == [0, 1]


def test_clusters_in_another_order_keep_their_particles(rng):
    states = np.concatenate([cloud(rng, 40.0, 0.2, 60), cloud(rng, -50.0, -0.3, 40)])
    before = grouped(states, np.full(100, 0.01), WIDTH)
    after = kernels.reordered(before, np.array([1, 0]))
    for old, new in zip(named(before), reversed(named(after)), strict=True):
        assert new.mass == old.mass
        assert (new.mean == old.mean).all()
        assert (new.members == old.members).all()
