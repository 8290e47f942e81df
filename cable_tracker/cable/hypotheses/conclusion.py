"""What is believed after the rounds of a frame: corrected weights, clusters, and their summary."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.clusters import (
    Clusters,
    clusters_of,
    find_groups,
    leading_covariance,
)
from cable_tracker.cable.hypotheses.evidence_correction import CorrectionRules, corrected_weights
from cable_tracker.cable.hypotheses.mixture_sample import log_weights
from cable_tracker.cable.hypotheses.proposals import (
    ProposalConfig,
    ProposalInputs,
    Sample,
    SampleCounts,
    draw_sample,
)
from cable_tracker.cable.measure.likelihood_ratio import bright_share
from cable_tracker.cable.model.geometry import unwrap_state
from cable_tracker.cable.model.state import STATE_SIZE, StateColumn
from cable_tracker.compilation import compiled, compiled_loop, compiled_part
from cable_tracker.particle_filter.weights import (
    effective_sample_size,
    exponentials,
    log_sum_exp,
    logarithms,
)

WIDTH = int(StateColumn.WIDTH)
"""Numba 0.59 takes no enumeration for an index beside a slice."""


class Conclusion(NamedTuple):
    """What the particles of a frame say; no cluster if all of them are impossible.

    Attributes
    ----------
    states, log_weights : FloatArray
        The particles, angles in (-pi/2, pi/2], shapes (N, 8) and (N,).
    log_evidence : float
        Logarithm of the likelihood ratio, a cable against none.
    clusters : Clusters
        Of the particles.
    covariance : FloatArray
        Of the leading cluster, in the chart of its mean, shape (8, 8).
    effective_size : float
        N_eff.
    border_evidence, visible_length : float
        See `Belief`.
    levels : FloatArray
        Mean log-likelihood ratio of each cluster, its width not judged, shape (K,).
    p_bright : float
        Share of the weight that speaks for a cable brighter than the bottom.
    """

    states: FloatArray
    log_weights: FloatArray
    log_evidence: float
    clusters: Clusters
    covariance: FloatArray
    effective_size: float
    border_evidence: float
    visible_length: float
    levels: FloatArray
    p_bright: float


@compiled
def draw_and_conclude(
    sample: Sample,
    inputs: ProposalInputs,
    counts: SampleCounts,
    config: ProposalConfig,
    anchors: FloatArray,
    rules: CorrectionRules,
) -> Conclusion:
    """Draw the particles of all rounds, weigh them, and conclude.

    `anchors` (0 or 1, 8) says where the cluster that leads is expected.
    """
    end = draw_sample(sample, inputs, counts, config)
    return conclude(sample, end, config.image_size[0], anchors, rules, inputs.p_bright)


@compiled_part
def conclude(
    sample: Sample,
    end: int,
    image_width: float,
    anchors: FloatArray,
    rules: CorrectionRules,
    p_bright: float,
) -> Conclusion:
    """Conclude from the first `end` rows of a sample."""
    states = sample.states[:end].copy()
    for row in range(end):
        unwrap_state(states[row], 0.0, states[row])
    densities, evidence = sample.densities, sample.evidence
    log_prior = log_weights(0.0, sample.ratios[:end], densities.full[:end], sample.mixture[:end])
    posterior = np.empty(end)
    for row in range(end):
        posterior[row] = log_prior[row] + sample.ratios[row]
    groups, count = find_groups(states, posterior, image_width, anchors)
    if count == 0:
        return _nothing(states, posterior)
    corrected = corrected_weights(
        posterior,
        log_prior,
        densities.full[:end],
        densities.survived[:end],
        densities.width_penalties[:end],
        states[:, WIDTH].copy(),
        groups,
        count,
        rules,
    )
    log_evidence = log_sum_exp(corrected)
    normalised = np.empty(end)
    for row in range(end):
        normalised[row] = corrected[row] - log_evidence
    weights = exponentials(normalised)
    clusters = clusters_of(states, weights, groups, count)
    if not len(clusters.masses):
        # Correcting may leave all groups light and the rest heavy.
        groups, count = find_groups(
            states, logarithms(weights), image_width, np.empty((0, STATE_SIZE))
        )
        clusters = clusters_of(states, weights, groups, count)
    border_evidence, visible_length, posterior_bright = _summary(
        clusters.labels,
        clusters.masses[0],
        weights,
        evidence.log_ratios[:end],
        evidence.weaker_borders[:end],
        evidence.visible_lengths[:end],
        p_bright,
    )
    return Conclusion(
        states,
        normalised,
        log_evidence,
        clusters,
        leading_covariance(states, weights, clusters),
        effective_sample_size(normalised),
        border_evidence,
        visible_length,
        _levels(clusters, weights, sample.ratios[:end], densities.width_penalties[:end]),
        posterior_bright,
    )


@compiled_part
def _levels(
    clusters: Clusters, weights: FloatArray, ratios: FloatArray, penalties: FloatArray
) -> FloatArray:
    """Return the mean log-likelihood ratio (K,) of each cluster, without what its width costs."""
    levels = np.zeros(len(clusters.masses))
    for row in range(len(weights)):
        label = clusters.labels[row]
        if label >= 0 and weights[row] > 0.0:
            levels[label] += weights[row] / clusters.masses[label] * (ratios[row] - penalties[row])
    return levels


@compiled_part
def _nothing(states: FloatArray, log_shares: FloatArray) -> Conclusion:
    clusters = Clusters(
        np.full(len(states), -1, np.int64), np.empty(0), np.empty((0, STATE_SIZE)), 1.0
    )
    covariance = np.zeros((STATE_SIZE, STATE_SIZE))
    return Conclusion(
        states, log_shares, -math.inf, clusters, covariance, 0.0, 0.0, 0.0, np.empty(0), 0.0
    )


@compiled_loop
def _summary(
    labels: IndexArray,
    mass: float,
    weights: FloatArray,
    log_ratios: FloatArray,
    weaker: FloatArray,
    visible_lengths: FloatArray,
    p_bright: float,
) -> tuple[float, float, float]:
    """Return evidence and visible length over the leader, and P(bright) over all particles."""
    odds = math.log(p_bright) - math.log1p(-p_bright)
    evidence, points, brightness = 0.0, 0.0, 0.0
    for row in range(len(labels)):
        log_odds = odds + log_ratios[row, 0] - log_ratios[row, 1]
        share = bright_share(log_odds)
        brightness += weights[row] * share
        if labels[row] == 0:
            evidence += weights[row] / mass * (weaker[row, 0] if share >= 0.5 else weaker[row, 1])
            points += weights[row] / mass * visible_lengths[row]
    return evidence, points, brightness
