"""Clusters of particles: the places where the cable may be.

The heaviest particle gathers those about it; of the rest the heaviest gathers again. Two cables, or
a cable and its shadow, come out as two clusters, and a mean is never taken across them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.model.geometry import relative_direction, state_in_chart
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    SKEW,
    STATE_SIZE,
    WIDTH,
)
from cable_tracker.compilation import compiled_loop, compiled_part
from cable_tracker.particle_filter.existence import probability_of

RADII = np.array([24.0, np.deg2rad(12.0), 30.0, np.deg2rad(10.0)])
"""Half-axes of the ellipsoid that a cluster fills at most: d, alpha, w, beta [px at the reference
width, rad]."""

MOST_CLUSTERS = 6

SMALLEST_MASS = 1e-9
"""Clusters with a smaller share of the weight are dropped."""

CENTRINGS = 2
"""Number of times that the members of a cluster are found and its mean updated."""

NO_CLUSTER = -1
"""Label of particles that belong to no cluster, or to no group."""


class Groups(NamedTuple):
    """Particles that lie together, in the order in which they were found.

    Attributes
    ----------
    labels : IndexArray
        Index of each particle's group, `NO_CLUSTER` for none, shape (N,).
    number : int
        Number of groups.
    """

    labels: IndexArray
    number: int


class Clusters(NamedTuple):
    """K clusters of N particles: the groups that weigh something, the leading one first.

    Attributes
    ----------
    labels : IndexArray
        Index of each particle's cluster, `NO_CLUSTER` for none, shape (N,).
    masses : FloatArray
        Sum of the weights of each cluster, shape (K,).
    means : FloatArray
        Weighted means, shape (K, 8); the angles are not wrapped.
    rest : float
        Sum of the weights of the particles of no cluster.
    """

    labels: IndexArray
    masses: FloatArray
    means: FloatArray
    rest: float


@compiled_part
def clusters_of(
    states: FloatArray, weights: FloatArray, groups: Groups
) -> tuple[Clusters, IndexArray]:
    """Return groups of particles as clusters, heaviest first, without those that weigh nothing.

    Also return the group that each comes from, shape (K,).
    """
    order, masses, means = group_means(states, weights, groups)
    labels = np.full(len(states), NO_CLUSTER, np.int64)
    rest = 0.0
    for row in range(len(labels)):
        for index in range(len(order)):
            if groups.labels[row] == order[index]:
                labels[row] = index
        if labels[row] == NO_CLUSTER:
            rest += weights[row]
    return Clusters(labels, masses, means, rest), order


@compiled_part
def most_probable_first(masses: FloatArray, log_odds: FloatArray) -> IndexArray:
    """Return the clusters by the probability that they are the cable, highest first, shape (K,).

    It is taken as the product of their masses, (K,), and of the probabilities that they are cables
    at all, of log-odds (K,) [nats]: what fits one frame best, but stands no higher than the bottom,
    does not lead while the cable of the frames before is still there.
    """
    probabilities = np.empty(len(masses))
    for index in range(len(masses)):
        probabilities[index] = masses[index] * probability_of(log_odds[index])
    return _descending_order(probabilities, -1.0)


@compiled_part
def reordered(clusters: Clusters, order: IndexArray) -> Clusters:
    """Return clusters in another order: the index of each before, shape (K,)."""
    labels = clusters.labels.copy()
    for index in range(len(order)):
        for row in range(len(labels)):
            if clusters.labels[row] == order[index]:
                labels[row] = index
    return Clusters(labels, clusters.masses[order], clusters.means[order], clusters.rest)


@compiled_part
def find_groups(
    states: FloatArray,
    log_weights: FloatArray,
    radii: FloatArray,
    most: int,
    least: float,
    anchors: FloatArray,
) -> Groups:
    """Return the groups of particles: about anchors, then each about the heaviest that is left.

    Parameters
    ----------
    states, log_weights : FloatArray
        The particles, shapes (N, 8) and (N,).
    radii : FloatArray
        `RADII` for frames of this size, shape (4,) [px, rad].
    most : int
        Maximum number of groups.
    least : float
        No group is found about a particle of at most this log-weight; -inf: only about none that
        weigh nothing.
    anchors : FloatArray
        States about which the first groups are found, shape (A, 8).
    """
    labels = np.full(len(states), NO_CLUSTER, np.int64)
    free, left = _possible_rows(log_weights)
    count = 0
    for anchor in anchors:
        labelled = _label_one_cluster(
            states, log_weights, radii, anchor, free[:left], labels, count
        )
        count += 1 if labelled else 0
        left = _still_free(free, left, labels)
    while count < most:
        heaviest = _heaviest_of(log_weights, free[:left], least)
        if heaviest < 0:
            break
        centre = states[heaviest]
        _label_one_cluster(states, log_weights, radii, centre, free[:left], labels, count)
        left = _still_free(free, left, labels)
        count += 1
    return Groups(labels, count)


@compiled_part
def group_centres(states: FloatArray, log_weights: FloatArray, groups: Groups) -> FloatArray:
    """Return the weighted means of all groups, shape (K, 8), however light a group is."""
    order, _, means = group_means(states, _shares_within(log_weights, groups), groups)
    centres = np.zeros((groups.number, STATE_SIZE))
    for index in range(len(order)):
        centres[order[index]] = means[index]
    return centres


@compiled_part
def _shares_within(log_weights: FloatArray, groups: Groups) -> FloatArray:
    """Return weights (N,) of which the largest in each group is one, however light the group."""
    labels = groups.labels
    peaks, shares = np.full(groups.number, -np.inf), np.zeros(len(labels))
    for row in range(len(labels)):
        if labels[row] >= 0:
            peaks[labels[row]] = max(peaks[labels[row]], log_weights[row])
    for row in range(len(labels)):
        if labels[row] >= 0 and log_weights[row] > -np.inf:
            shares[row] = math.exp(log_weights[row] - peaks[labels[row]])
    return shares


@compiled_part
def _possible_rows(log_weights: FloatArray) -> tuple[IndexArray, int]:
    """Return the rows of particles that weigh something, shape (N,), and their number."""
    rows, count = np.empty(len(log_weights), np.int64), 0
    for row in range(len(log_weights)):
        rows[count] = row
        count += log_weights[row] != -math.inf
    return rows, count


@compiled_loop
def _still_free(free: IndexArray, left: int, labels: IndexArray) -> int:
    """Move the rows of no group to the front, in their order, and return how many they are."""
    count = 0
    for index in range(left):
        row = free[index]
        free[count] = row
        count += labels[row] == NO_CLUSTER
    return count


@compiled_loop
def _heaviest_of(log_weights: FloatArray, rows: IndexArray, least: float) -> int:
    """Return the heaviest of some particles; -1 if none has more than the least log-weight."""
    heaviest, most = -1, least
    for row in rows:
        if log_weights[row] > most:
            heaviest, most = row, log_weights[row]
    return heaviest


@compiled_part
def _label_one_cluster(
    states: FloatArray,
    log_weights: FloatArray,
    radii: FloatArray,
    centre: FloatArray,
    free: IndexArray,
    labels: IndexArray,
    label: int,
) -> bool:
    """Label the particles of the rows `free` about a centre; tell whether there are any."""
    mean = centre[:POSE_SIZE].copy()
    members, count = np.empty(len(free), np.int64), 0
    for centring in range(CENTRINGS):
        gathered, found = _rows_about(states, radii, mean, free)
        # The mean of a ring-shaped cluster may lie outside it: then its members stay.
        if found == 0:
            break
        members, count = gathered, found
        if centring + 1 < CENTRINGS:
            _update_mean(states, log_weights, members[:count], mean)
    for index in range(count):
        labels[members[index]] = label
    return count > 0


@compiled_part
def _rows_about(
    states: FloatArray, radii: FloatArray, mean: FloatArray, rows: IndexArray
) -> tuple[IndexArray, int]:
    """Return which of some rows lie inside the ellipsoid `radii` about `mean`, and their number."""
    inside, count = np.empty(len(rows), np.int64), 0
    for row in rows:
        wrapped, sign = relative_direction(states[row, ANGLE], mean[ANGLE])
        a = (sign * states[row, DISTANCE] - mean[DISTANCE]) / radii[DISTANCE]
        b = wrapped / radii[ANGLE]
        c = (states[row, WIDTH] - mean[WIDTH]) / radii[WIDTH]
        d = (sign * states[row, SKEW] - mean[SKEW]) / radii[SKEW]
        # Without a branch, which could not be predicted.
        inside[count] = row
        count += a * a + b * b + c * c + d * d <= 1.0
    return inside, count


@compiled_part
def _update_mean(
    states: FloatArray, log_weights: FloatArray, members: IndexArray, mean: FloatArray
) -> None:
    """Replace a mean (4,) by that of its members, in the chart about its angle."""
    reference = mean[ANGLE]
    most = -math.inf
    for row in members:
        most = max(most, log_weights[row])
    total = 0.0
    sums = np.zeros(POSE_SIZE)
    for row in members:
        weight = math.exp(log_weights[row] - most)
        wrapped, sign = relative_direction(states[row, ANGLE], reference)
        total += weight
        sums[DISTANCE] += weight * sign * states[row, DISTANCE]
        sums[ANGLE] += weight * (wrapped + reference)
        sums[WIDTH] += weight * states[row, WIDTH]
        sums[SKEW] += weight * sign * states[row, SKEW]
    for column in range(POSE_SIZE):
        mean[column] = sums[column] / total


@compiled_part
def group_means(
    states: FloatArray, weights: FloatArray, groups: Groups
) -> tuple[IndexArray, FloatArray, FloatArray]:
    """Return labels, masses and means of the groups that weigh something, heaviest first.

    Shapes (K,), (K,), (K, 8). A mean is taken in the chart about the heaviest member.
    """
    masses, heaviest = _group_masses(weights, groups), heaviest_members(weights, groups)
    means = _means_about_heaviest(states, weights, groups, masses, heaviest)
    order = _descending_order(masses, SMALLEST_MASS)
    return order, masses[order], means[order]


@compiled_part
def _group_masses(weights: FloatArray, groups: Groups) -> FloatArray:
    """Return the sum of weights of each group, shape (K,)."""
    masses = np.zeros(groups.number)
    for row in range(len(groups.labels)):
        if groups.labels[row] != NO_CLUSTER:
            masses[groups.labels[row]] += weights[row]
    return masses


@compiled_part
def heaviest_members(weights: FloatArray, groups: Groups) -> IndexArray:
    """Return the row of the heaviest particle of each group, shape (K,).

    The weights, shape (N,), may be logarithms. Of equal ones it is the first.
    """
    labels, heaviest = groups.labels, np.full(groups.number, -1, np.int64)
    for row in range(len(labels)):
        label = labels[row]
        if label == NO_CLUSTER:
            continue
        if heaviest[label] < 0 or weights[row] > weights[heaviest[label]]:
            heaviest[label] = row
    return heaviest


@compiled_part
def _means_about_heaviest(
    states: FloatArray,
    weights: FloatArray,
    groups: Groups,
    masses: FloatArray,
    heaviest: IndexArray,
) -> FloatArray:
    """Return the weighted means (K, 8), particles in the chart about the heaviest."""
    labels, count = groups
    means, member = np.zeros((count, STATE_SIZE)), np.empty(STATE_SIZE)
    for row in range(len(labels)):
        label = labels[row]
        if label != NO_CLUSTER and masses[label] > SMALLEST_MASS:
            state_in_chart(states[row], states[heaviest[label], ANGLE], member)
            share = weights[row] / masses[label]
            for column in range(STATE_SIZE):
                means[label, column] += share * member[column]
    return means


@compiled_part
def _descending_order(values: FloatArray, least: float) -> IndexArray:
    """Return the indices of the values above `least`, largest first; of equal ones the first."""
    order: IndexArray = np.argsort(-values, kind="mergesort")[: np.count_nonzero(values > least)]
    return order


@compiled_part
def group_covariance(
    states: FloatArray,
    weights: FloatArray,
    labels: IndexArray,
    label: int,
    mass: float,
    mean: FloatArray,
) -> FloatArray:
    """Return the covariance (K, K) of a group about the first K components of its mean, (K,).

    It is that in the mean's chart.
    """
    size = len(mean)
    covariance = np.zeros((size, size))
    deviation = np.empty(STATE_SIZE)
    for row in range(len(labels)):
        if labels[row] != label:
            continue
        state_in_chart(states[row], mean[ANGLE], deviation)
        share = weights[row] / mass
        for first in range(size):
            deviation[first] -= mean[first]
            for second in range(first + 1):
                covariance[first, second] += share * deviation[first] * deviation[second]
    for first in range(size):
        for second in range(first):
            covariance[second, first] = covariance[first, second]
    return covariance
