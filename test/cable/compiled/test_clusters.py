from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses import clusters as plain
from cable_tracker.cable.model.geometry import wrap_states

pytest.importorskip("numba")

from cable_tracker.cable.compiled.clusters import (
    NONE,
    find_groups,
    group_covariance,
    group_means,
    leading_covariance,
)

WIDTH = 320
NO_ANCHOR = np.empty((0, 8))
SEEDS = st.integers(0, 2**32 - 1)
COUNTS = st.integers(1, 80)


def any_particles(seed, count) -> tuple[np.ndarray, np.ndarray]:
    """A few clouds, one across the wrap, and stray particles; some weigh nothing."""
    rng = np.random.default_rng(seed)
    spread = np.array([8.0, 0.08, 8.0, 0.05, 1.0, 0.1, 1.0, 0.1])
    centres = rng.uniform(-1, 1, (4, 8)) * np.array([150, np.pi / 2, 20, 0.1, 9, 1, 9, 1])
    centres[:, 2] += 40.0
    centres[0, 1] = np.pi / 2
    states = centres[rng.integers(0, 4, count)] + rng.standard_normal((count, 8)) * spread
    weights = rng.dirichlet(np.full(count, 0.3)) * (rng.random(count) < 0.9)
    weights = weights / weights.sum() if weights.sum() > 0 else np.full(count, 1.0 / count)
    return wrap_states(states), weights


def log_of(weights) -> np.ndarray:
    with np.errstate(divide="ignore"):
        return np.log(weights)


def labels_from(groups, count) -> np.ndarray:
    labels = np.full(count, NONE)
    for number, members in enumerate(groups):
        labels[members] = number
    return labels


@given(SEEDS, COUNTS, st.booleans())
def test_groups_have_the_same_members(seed, count, anchored):
    states, weights = any_particles(seed, count)
    anchor = states[seed % count] + 3.0 if anchored else None
    expected = plain.find_groups(states, log_of(weights), WIDTH, anchor)
    anchors = NO_ANCHOR if anchor is None else anchor[None]
    labels, number = find_groups(states, log_of(weights), float(WIDTH), anchors)
    assert number == len(expected)
    np.testing.assert_array_equal(labels, labels_from(expected, count))


@given(SEEDS, COUNTS)
def test_clusters_have_the_same_mass_mean_and_covariance(seed, count):
    states, weights = any_particles(seed, count)
    expected = plain.find_clusters(states, weights, WIDTH)
    labels, number = find_groups(states, log_of(weights), float(WIDTH), NO_ANCHOR)
    order, masses, means = group_means(states, weights, labels, number)
    np.testing.assert_allclose(masses, [cluster.mass for cluster in expected])
    np.testing.assert_allclose(means, [cluster.mean for cluster in expected], atol=1e-9)
    for label, mass, mean, cluster in zip(order, masses, means, expected, strict=True):
        np.testing.assert_array_equal(labels == label, cluster.members)
        covariance = group_covariance(states, weights, labels, label, mass, mean, 8)
        np.testing.assert_allclose(covariance, cluster.covariance(states, weights), atol=1e-9)
        of_places = group_covariance(states, weights, labels, label, mass, mean, 4)
        np.testing.assert_array_equal(of_places, covariance[:4, :4])


@given(SEEDS, COUNTS)
def test_the_leading_covariance_is_that_of_its_members(seed, count):
    states, weights = any_particles(seed, count)
    for cluster in plain.find_clusters(states, weights, WIDTH):
        found = leading_covariance(
            states, log_of(weights), cluster.members, cluster.mass, cluster.mean
        )
        np.testing.assert_allclose(found, cluster.covariance(states, weights), atol=1e-9)


def test_no_weight_at_all_is_no_group():
    states, _ = any_particles(0, 10)
    labels, number = find_groups(states, np.full(10, -np.inf), float(WIDTH), NO_ANCHOR)
    assert number == 0
    assert (labels == NONE).all()


def test_what_weighs_nothing_in_numbers_is_a_group_and_no_cluster():
    states = np.zeros((2, 8))
    states[:, 2] = 30.0
    states[1, 0] = 100.0
    labels, number = find_groups(states, np.array([0.0, -2000.0]), float(WIDTH), NO_ANCHOR)
    assert labels.tolist() == [0, 1]
    order, _, means = group_means(states, np.array([1.0, 0.0]), labels, number)
    assert order.tolist() == [0]
    np.testing.assert_array_equal(means, states[:1])
