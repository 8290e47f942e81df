"""See `cable_tracker.cable.hypotheses.clusters`."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.compiled.geometry import turn_sign, unwrap_state, wrapped_angle
from cable_tracker.cable.hypotheses.clusters import CENTRINGS, MOST_CLUSTERS, RADII, SMALLEST_MASS
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH
from cable_tracker.compilation import compiled

NONE = -1
"""Label of particles that belong to no group."""


@compiled
def find_groups(
    states: FloatArray, log_weights: FloatArray, image_width: float, anchors: FloatArray
) -> tuple[IndexArray, int]:
    """Return the group of each particle (N,), `NONE` for none, and the number of groups.

    `anchors` (0 or 1, 8) says where the first group is looked for.
    """
    scale = image_width / REFERENCE_WIDTH
    radii = np.array([RADII[0] * scale, RADII[1], RADII[2] * scale, RADII[3]])
    labels = np.full(len(states), NONE, np.int64)
    gathered = np.empty(len(states), np.bool_)
    count = 0
    if len(anchors):
        count += _take(states, log_weights, radii, anchors[0], labels, gathered, count)
    while count < MOST_CLUSTERS:
        heaviest = _heaviest(log_weights, labels, NONE)
        if heaviest < 0:
            break
        count += _take(states, log_weights, radii, states[heaviest], labels, gathered, count)
    return labels, count


@compiled
def _heaviest(log_weights: FloatArray, labels: IndexArray, label: int) -> int:
    """Return the heaviest particle with a label; -1 if all of them weigh nothing."""
    heaviest, most = -1, -math.inf
    for row in range(len(labels)):
        if labels[row] == label and log_weights[row] > most:
            heaviest, most = row, log_weights[row]
    return heaviest


@compiled
def _take(
    states: FloatArray,
    log_weights: FloatArray,
    radii: FloatArray,
    centre: FloatArray,
    labels: IndexArray,
    members: BoolArray,
    label: int,
) -> int:
    """Label the particles about a centre; return 1 if there are any, else 0."""
    mean = centre[:4].copy()
    found = False
    for _ in range(CENTRINGS):
        if not _gather(states, log_weights, radii, mean, labels, members, found):
            break
        found = True
        _centre(states, log_weights, members, mean)
    if not found:
        return 0
    for row in range(len(labels)):
        if members[row]:
            labels[row] = label
    return 1


@compiled
def _gather(
    states: FloatArray,
    log_weights: FloatArray,
    radii: FloatArray,
    mean: FloatArray,
    labels: IndexArray,
    members: BoolArray,
    keep: bool,
) -> bool:
    """Mark the free particles about a mean. If there is none, `keep` leaves the marks as they are.

    The mean of a ring may lie on none of its particles; they stay together.
    """
    gathered = np.zeros(len(labels), np.bool_)
    any_gathered = False
    for row in range(len(labels)):
        if labels[row] != NONE or log_weights[row] == -math.inf:
            continue
        shifted = states[row, 1] - mean[1]
        wrapped = wrapped_angle(shifted)
        sign = turn_sign(shifted, wrapped)
        a = (sign * states[row, 0] - mean[0]) / radii[0]
        b = wrapped / radii[1]
        c = (states[row, 2] - mean[2]) / radii[2]
        d = (sign * states[row, 3] - mean[3]) / radii[3]
        if a * a + b * b + c * c + d * d <= 1.0:
            gathered[row] = True
            any_gathered = True
    if any_gathered or not keep:
        members[:] = gathered
    return any_gathered


@compiled
def _centre(
    states: FloatArray, log_weights: FloatArray, members: BoolArray, mean: FloatArray
) -> None:
    """Move a mean (4,) to that of its members, in the chart about its angle."""
    reference = mean[1]
    most = -math.inf
    for row in range(len(members)):
        if members[row]:
            most = max(most, log_weights[row])
    total = 0.0
    sums = np.zeros(4)
    for row in range(len(members)):
        if not members[row]:
            continue
        weight = math.exp(log_weights[row] - most)
        shifted = states[row, 1] - reference
        wrapped = wrapped_angle(shifted)
        sign = turn_sign(shifted, wrapped)
        total += weight
        sums[0] += weight * sign * states[row, 0]
        sums[1] += weight * (wrapped + reference)
        sums[2] += weight * states[row, 2]
        sums[3] += weight * sign * states[row, 3]
    for column in range(4):
        mean[column] = sums[column] / total


@compiled
def group_means(
    states: FloatArray, weights: FloatArray, labels: IndexArray, count: int
) -> tuple[IndexArray, FloatArray, FloatArray]:
    """Return labels, masses and means of the groups that weigh something, heaviest first.

    Shapes (K,), (K,), (K, 8). A mean is taken in the chart about the heaviest member.
    """
    masses, means = np.zeros(count), np.zeros((count, 8))
    heaviest = np.full(count, -1, np.int64)
    for row in range(len(labels)):
        label = labels[row]
        if label != NONE:
            masses[label] += weights[row]
            if heaviest[label] < 0 or weights[row] > weights[heaviest[label]]:
                heaviest[label] = row
    place = np.empty(8)
    for row in range(len(labels)):
        label = labels[row]
        if label != NONE and masses[label] > SMALLEST_MASS:
            unwrap_state(states[row], states[heaviest[label], 1], place)
            share = weights[row] / masses[label]
            for column in range(8):
                means[label, column] += share * place[column]
    order = np.argsort(-masses, kind="mergesort")
    order = order[masses[order] > SMALLEST_MASS]
    return order, masses[order], means[order]


@compiled
def group_covariance(
    states: FloatArray,
    weights: FloatArray,
    labels: IndexArray,
    label: int,
    mass: float,
    mean: FloatArray,
    size: int,
) -> FloatArray:
    """Return the covariance of the first `size` components of a group, in its mean's chart."""
    covariance = np.zeros((size, size))
    deviation = np.empty(8)
    for row in range(len(labels)):
        if labels[row] != label:
            continue
        unwrap_state(states[row], mean[1], deviation)
        share = weights[row] / mass
        for first in range(size):
            deviation[first] -= mean[first]
            for second in range(first + 1):
                covariance[first, second] += share * deviation[first] * deviation[second]
    for first in range(size):
        for second in range(first):
            covariance[second, first] = covariance[first, second]
    return covariance


@compiled
def leading_covariance(
    states: FloatArray, log_weights: FloatArray, members: BoolArray, mass: float, mean: FloatArray
) -> FloatArray:
    """Return the covariance (8, 8) of a cluster with members (N,)."""
    labels = np.where(members, 0, NONE)
    return group_covariance(states, np.exp(log_weights), labels, 0, mass, mean, 8)
