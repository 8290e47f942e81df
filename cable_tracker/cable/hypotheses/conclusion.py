"""What is believed after the rounds of a frame: corrected weights, clusters, and their summary."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.background import SPREADS_ABOVE, Background, background_of
from cable_tracker.cable.hypotheses.clusters import (
    Clusters,
    clusters_of,
    find_groups,
    group_means,
    leading_covariance,
)
from cable_tracker.cable.hypotheses.evidence_correction import CorrectionRules, corrected_weights
from cable_tracker.cable.hypotheses.mixture_sample import log_weights
from cable_tracker.cable.hypotheses.proposals import (
    ProposalConfig,
    ProposalInputs,
    Sample,
    draw_sample,
)
from cable_tracker.cable.hypotheses.sample_counts import SampleCounts
from cable_tracker.cable.measure.likelihood_ratio import border_clearness, bright_share
from cable_tracker.cable.model.geometry import unwrap_state
from cable_tracker.cable.model.state import STATE_SIZE, StateColumn
from cable_tracker.compilation import compiled, compiled_loop, compiled_part
from cable_tracker.particle_filter.weights import (
    effective_sample_size,
    exponentials,
    normalise_log_weights,
)

WIDTH = int(StateColumn.WIDTH)
"""Numba 0.59 takes no enumeration for an index beside a slice."""


class Conclusion(NamedTuple):
    """What the particles of a frame say; no cluster if all of them are impossible.

    Attributes
    ----------
    states, log_weights : FloatArray
        The particles, angles in (-pi/2, pi/2], shapes (N, 8) and (N,).
    clusters : Clusters
        Of the particles.
    covariance : FloatArray
        Of the leading cluster, in the chart of its mean, shape (8, 8).
    effective_size : float
        N_eff.
    border_evidence, visible_length : float
        See `Belief`.
    levels : FloatArray
        Mean log-likelihood ratio of each cluster, its width not judged, above that of the best
        strips of the bottom, like it or not, shape (K,).
    scores : FloatArray
        The same above the mean of strips of any kind, in their spreads, shape (K,).
    clearness, shown : FloatArray
        See `BorderClearness`; of the mean of each cluster.
    p_bright : float
        Share of the weight that speaks for a cable brighter than the bottom.
    """

    states: FloatArray
    log_weights: FloatArray
    clusters: Clusters
    covariance: FloatArray
    effective_size: float
    border_evidence: float
    visible_length: float
    levels: FloatArray
    scores: FloatArray
    clearness: FloatArray
    shown: FloatArray
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
    return conclude(sample, end, inputs, config, anchors, rules)


@compiled_part
def conclude(
    sample: Sample,
    end: int,
    inputs: ProposalInputs,
    config: ProposalConfig,
    anchors: FloatArray,
    rules: CorrectionRules,
) -> Conclusion:
    """Conclude from the first `end` rows of a sample."""
    states = _wrapped_states(sample, end)
    densities, evidence = sample.densities, sample.evidence
    log_prior = log_weights(0.0, sample.ratios[:end], densities.full[:end], sample.mixture[:end])
    log_posterior = _sum(log_prior, sample.ratios)
    groups, count = find_groups(states, log_posterior, config.image_size[0], anchors)
    if count == 0:
        return _nothing(states, log_posterior)
    background = _background(states, log_posterior, groups, count, inputs, config)
    corrected = corrected_weights(
        log_posterior,
        log_prior,
        densities.full[:end],
        densities.survived[:end],
        densities.width_penalties[:end],
        states[:, WIDTH].copy(),
        groups,
        count,
        background.alike,
        rules,
    )
    normalised, _, _ = normalise_log_weights(corrected)
    weights = exponentials(normalised)
    clusters = clusters_of(states, weights, groups, count)
    if not len(clusters.masses):
        # Correcting may leave all groups light and the rest heavy.
        groups, count = find_groups(states, normalised, config.image_size[0], anchors[:0])
        background = _background(states, normalised, groups, count, inputs, config)
        clusters = clusters_of(states, weights, groups, count)
    border_evidence, visible_length, posterior_bright = _summary(
        clusters.labels,
        clusters.masses[0],
        weights,
        evidence.log_ratios[:end],
        evidence.weaker_borders[:end],
        evidence.visible_lengths[:end],
        inputs.p_bright,
    )
    levels, scores = _above(
        clusters,
        weights,
        sample.ratios[:end],
        densities.width_penalties[:end],
        groups,
        background,
    )
    clear = border_clearness(clusters.means, inputs.scan, inputs.model)
    return Conclusion(
        states,
        normalised,
        clusters,
        leading_covariance(states, weights, clusters),
        effective_sample_size(normalised),
        border_evidence,
        visible_length,
        levels,
        scores,
        clear.clearness,
        clear.shown,
        posterior_bright,
    )


@compiled_part
def _wrapped_states(sample: Sample, end: int) -> FloatArray:
    """Return the first rows of a sample with angles in (-pi/2, pi/2]."""
    states = sample.states[:end].copy()
    for row in range(end):
        unwrap_state(states[row], 0.0, states[row])
    return states


@compiled_part
def _sum(log_prior: FloatArray, log_ratios: FloatArray) -> FloatArray:
    """Return the logarithms of prior times likelihood; `log_ratios` may have more rows."""
    result = np.empty(len(log_prior))
    for row in range(len(log_prior)):
        result[row] = log_prior[row] + log_ratios[row]
    return result


@compiled_part
def _above(
    clusters: Clusters,
    weights: FloatArray,
    ratios: FloatArray,
    penalties: FloatArray,
    groups: IndexArray,
    background: Background,
) -> tuple[FloatArray, FloatArray]:
    """Return levels and scores of `Conclusion`; `groups` are those before they were sorted."""
    count = len(clusters.masses)
    levels, scores = np.zeros(count), np.zeros(count)
    for row in range(len(weights)):
        label = clusters.labels[row]
        if label >= 0 and weights[row] > 0.0:
            share, group = weights[row] / clusters.masses[label], groups[row]
            ratio = ratios[row] - penalties[row]
            mean, spread = background.means[group], background.spreads[group]
            best = max(background.alike[group], mean + SPREADS_ABOVE * spread)
            levels[label] += share * (ratio - best)
            scores[label] += share * (ratio - mean) / spread
    return levels, scores


@compiled_part
def _background(
    states: FloatArray,
    log_weights: FloatArray,
    groups: IndexArray,
    count: int,
    inputs: ProposalInputs,
    config: ProposalConfig,
) -> Background:
    """Return the background of each group."""
    shares = _within_groups(log_weights, groups, count)
    order, _, means = group_means(states, shares, groups, count)
    found = background_of(
        means,
        inputs.noise,
        inputs.scan,
        inputs.model,
        inputs.p_bright,
        config.lower,
        config.upper,
        config.image_size,
    )
    background = Background(np.zeros(count), np.zeros(count), np.ones(count))
    for index in range(len(order)):
        group = order[index]
        background.alike[group] = found.alike[index]
        background.means[group] = found.means[index]
        background.spreads[group] = found.spreads[index]
    return background


@compiled_part
def _within_groups(log_weights: FloatArray, groups: IndexArray, count: int) -> FloatArray:
    """Return weights (N,) of which the largest in each group is one, however light the group."""
    peaks, shares = np.full(count, -np.inf), np.zeros(len(groups))
    for row in range(len(groups)):
        if groups[row] >= 0:
            peaks[groups[row]] = max(peaks[groups[row]], log_weights[row])
    for row in range(len(groups)):
        if groups[row] >= 0 and log_weights[row] > -np.inf:
            shares[row] = math.exp(log_weights[row] - peaks[groups[row]])
    return shares


@compiled_part
def _nothing(states: FloatArray, log_shares: FloatArray) -> Conclusion:
    clusters = Clusters(
        np.full(len(states), -1, np.int64), np.empty(0), np.empty((0, STATE_SIZE)), 1.0
    )
    covariance = np.zeros((STATE_SIZE, STATE_SIZE))
    return Conclusion(
        states,
        log_shares,
        clusters,
        covariance,
        0.0,
        0.0,
        0.0,
        np.empty(0),
        np.empty(0),
        np.empty(0),
        np.empty(0),
        0.0,
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
