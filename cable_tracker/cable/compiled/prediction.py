"""The step from one frame to the next: which particles go on, and where they drift.

See `MultiHypothesisFilter._survivors`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.compiled.clusters import NONE
from cable_tracker.cable.compiled.geometry import unwrap_state
from cable_tracker.cable.hypotheses.clusters import SMALLEST_MASS
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import (
    LEAST_SURVIVING,
    SMALLEST_CLUSTER_SHARE,
)
from cable_tracker.compilation import compiled
from cable_tracker.tracking.survival import SurvivalRates, survival_probability


class Step(NamedTuple):
    """The way from one frame to the next.

    Attributes
    ----------
    reference_angle : float
        Middle of the chart [rad].
    size : (float, float)
        Width and height of the frames [px].
    rates : SurvivalRates
        How often a cable goes out of view.
    dt, effective_time, damping : float
        Time [s], for how long undamped rates would cover the same way [s], factor on the rates.
    """

    reference_angle: float
    size: tuple[float, float]
    rates: SurvivalRates
    dt: float
    effective_time: float
    damping: float


class Groups(NamedTuple):
    """The clusters that have ancestors, and the particles of none: G groups.

    Attributes
    ----------
    weights : FloatArray
        Of the particles, shape (N,).
    labels : IndexArray
        The group of each particle, shape (N,); `NONE` for one whose group has no ancestors.
    masses, counts : FloatArray, IndexArray
        Weight of each group and how many ancestors it has, shape (G,).
    """

    weights: FloatArray
    labels: IndexArray
    masses: FloatArray
    counts: IndexArray


@compiled
def ancestor_groups(members: BoolArray, log_weights: FloatArray, count: int) -> Groups:
    """Share out `count` ancestors among clusters with members (K, N), and those of none."""
    weights = np.exp(log_weights)
    rest = len(members)
    labels = np.full(len(weights), rest, np.int64)
    masses = np.zeros(rest + 1)
    for row in range(len(weights)):
        for cluster in range(rest):
            if members[cluster, row]:
                labels[row] = cluster
        masses[labels[row]] += weights[row]
    numbers = np.full(rest + 1, NONE, np.int64)
    kept = np.flatnonzero(masses > SMALLEST_MASS)
    numbers[kept] = np.arange(len(kept))
    for row in range(len(weights)):
        labels[row] = numbers[labels[row]]
    wanted = np.maximum(masses[kept], SMALLEST_CLUSTER_SHARE)
    counts = np.maximum(np.rint(wanted / wanted.sum() * count), 1.0).astype(np.int64)
    return Groups(weights, labels, masses[kept], counts)


@compiled
def survivors_of(
    states: FloatArray, groups: Groups, offsets: FloatArray, step: Step
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Return the fields of `Survivors`; `offsets` (G,), 0 to 1, are those of the resampling."""
    indices = _choose(groups, offsets)
    counts = groups.counts
    target = np.empty(len(indices))
    first = 0
    for group in range(len(counts)):
        target[first : first + counts[group]] = groups.masses[group] / counts[group]
        first += counts[group]
    return _drifted(states, indices, target / target.sum(), step)


@compiled
def _choose(groups: Groups, offsets: FloatArray) -> IndexArray:
    """Draw from every group its number of ancestors, by systematic resampling within it."""
    weights, labels, masses, counts = groups
    indices = np.empty(counts.sum(), np.int64)
    drawn = 0
    for group in range(len(counts)):
        total, last = 0.0, -1
        for row in range(len(labels)):
            if labels[row] == group:
                total += weights[row] / masses[group]
                if weights[row] > 0.0:
                    last = row
        cumulative, row = 0.0, -1
        for number in range(counts[group]):
            position = (number + offsets[group]) / counts[group] * total
            while row < last and cumulative <= position:
                row += 1
                if labels[row] == group:
                    cumulative += weights[row] / masses[group]
            indices[drawn] = row
            drawn += 1
    return indices


@compiled
def _drifted(
    states: FloatArray, indices: IndexArray, weights: FloatArray, step: Step
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    places, rates = np.empty((len(indices), 4)), np.empty((len(indices), 4))
    surviving = np.empty(len(indices))
    ancestor = np.empty(8)
    for row in range(len(indices)):
        unwrap_state(states[indices[row]], step.reference_angle, ancestor)
        surviving[row] = max(weights[row] * _survival(ancestor, step), LEAST_SURVIVING)
        for column in range(4):
            rate = ancestor[4 + column]
            places[row, column] = ancestor[column] + rate * step.effective_time
            rates[row, column] = rate * step.damping
    total = surviving.sum()
    return places, rates, surviving / total, total


@compiled
def _survival(state: FloatArray, step: Step) -> float:
    """Return the probability that a cable is still in view."""
    width, height = step.size
    reach = (abs(math.cos(state[1])) * width + abs(math.sin(state[1])) * height) / 2
    return survival_probability(reach - abs(state[0]), step.rates, step.dt)
