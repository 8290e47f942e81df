"""What is believed after the rounds of a frame; see `MultiHypothesisFilter._conclude`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.compiled.clusters import find_groups, group_means
from cable_tracker.cable.compiled.geometry import wrap_states
from cable_tracker.cable.compiled.mixture_sample import Balance, balance, log_weights, summary
from cable_tracker.cable.compiled.rounds import Sample
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.compiled.weights import log_sum_exp


class Conclusion(NamedTuple):
    """Particles, clusters (heaviest first) and what they say; no cluster if all is impossible.

    `log_evidence` is the logarithm of the likelihood ratio, a cable against none.
    """

    states: FloatArray
    log_weights: FloatArray
    log_evidence: float
    masses: FloatArray
    means: FloatArray
    members: BoolArray
    clearness: float
    seen: float
    brightness: float


@compiled
def conclude(
    sample: Sample,
    end: int,
    image_width: float,
    anchors: FloatArray,
    rules: Balance,
    bright: float,
) -> Conclusion:
    """Conclude from the first `end` rows of a sample."""
    states = wrap_states(sample.states[:end])
    densities, evidence = sample.densities, sample.evidence
    log_prior = log_weights(0.0, sample.ratios[:end], densities.full[:end], sample.mixture[:end])
    posterior = log_prior + sample.ratios[:end]
    labels, count = find_groups(states, posterior, image_width, anchors)
    if count == 0:
        return _nothing(states, posterior)
    balanced = balance(
        posterior,
        log_prior,
        densities.full[:end],
        densities.survived[:end],
        densities.width_factors[:end],
        labels,
        count,
        rules,
    )
    log_evidence = log_sum_exp(balanced)
    normalised = balanced - log_evidence
    weights = np.exp(normalised)
    order, masses, means = group_means(states, weights, labels, count)
    if not len(order):
        # Balancing may leave all named groups light and the rest heavy.
        labels, count = find_groups(states, np.log(weights), image_width, np.empty((0, 8)))
        order, masses, means = group_means(states, weights, labels, count)
    clearness, seen, brightness = summary(
        labels,
        order[0],
        masses[0],
        weights,
        evidence.log_ratios[:end],
        evidence.weaker_borders[:end],
        evidence.seen[:end],
        bright,
    )
    members = _members(labels, order)
    return Conclusion(
        states, normalised, log_evidence, masses, means, members, clearness, seen, brightness
    )


@compiled
def _nothing(states: FloatArray, log_shares: FloatArray) -> Conclusion:
    none = np.empty((0, len(states)), np.bool_)
    return Conclusion(
        states, log_shares, -math.inf, np.empty(0), np.empty((0, 8)), none, 0.0, 0.0, 0.0
    )


@compiled
def _members(labels: IndexArray, order: IndexArray) -> BoolArray:
    members = np.empty((len(order), len(labels)), np.bool_)
    for cluster in range(len(order)):
        for row in range(len(labels)):
            members[cluster, row] = labels[row] == order[cluster]
    return members
