"""What is believed after the rounds of a frame: corrected weights, clusters, and their summary."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.background import (
    BEST_OF_ANY,
    Background,
    background_of,
)
from cable_tracker.cable.hypotheses.belief import Hypotheses, unmeasured_hypotheses
from cable_tracker.cable.hypotheses.clusters import (
    MOST_CLUSTERS,
    NO_CLUSTER,
    Clusters,
    Groups,
    clusters_of,
    find_groups,
    group_centres,
    group_covariance,
    most_probable_first,
    reordered,
)
from cable_tracker.cable.hypotheses.evidence_correction import (
    WeighedParticles,
    corrected_log_weights,
)
from cable_tracker.cable.hypotheses.frame_inputs import FrameConfig, FrameInputs
from cable_tracker.cable.hypotheses.presence import (
    KNOWN_MODEL,
    MODEL,
    FrameScores,
    inherited_log_odds,
    is_same_hypothesis,
    scaled_pose_distance,
    shown_share,
    thin_factor,
    trusted_appearance,
    updated_log_odds,
)
from cable_tracker.cable.hypotheses.proposals import (
    Sample,
    draw_sample,
    importance_log_weights,
)
from cable_tracker.cable.measure.borders.appearance import appearances_of
from cable_tracker.cable.measure.borders.likelihood_ratio import (
    BRIGHT,
    DARK,
    BorderClearness,
    border_clearness,
    bright_share,
    measured_cables,
)
from cable_tracker.cable.measure.map.cable_map import is_worked_out, map_match
from cable_tracker.cable.model.geometry import state_in_chart
from cable_tracker.cable.model.state import STATE_SIZE, WIDTH
from cable_tracker.compilation import compiled, compiled_inside, compiled_loop, compiled_part
from cable_tracker.particle_filter.existence import probability_of
from cable_tracker.particle_filter.particles import (
    effective_sample_size,
    exponentials,
    normalise_log_weights,
)


class Conclusion(NamedTuple):
    """What the particles of a frame say; no cluster if all of them are impossible.

    Attributes
    ----------
    states, log_weights : FloatArray
        The particles, angles in (-pi/2, pi/2], shapes (N, 8) and (N,).
    hypotheses : Hypotheses
        Their clusters, and what the frame measures of the leading one.
    log_odds : FloatArray
        Log-odds that the clusters are cables, shape (K,) [nats].
    p_bright : float
        Weighted share of bright cables: probability that the cable is brighter than the bottom.
    presence : float
        Probability that the first of the clusters is a cable.
    deviation : float
        How far the first one is from where the one that led before the frame is expected, see
        `scaled_pose_distance`.
    goes_on : bool
        Whether it continues that one: the deviation is below 1.
    """

    states: FloatArray
    log_weights: FloatArray
    hypotheses: Hypotheses
    log_odds: FloatArray
    p_bright: float
    presence: float
    deviation: float
    goes_on: bool


@compiled
def draw_and_conclude(sample: Sample, inputs: FrameInputs, config: FrameConfig) -> Conclusion:
    """Draw the particles of all rounds, weigh them, and conclude.

    About each of the candidates particles are one group, however little they weigh.
    """
    drawn = draw_sample(sample, inputs, config)
    states = _wrapped_states(sample, drawn.filled)
    log_prior = importance_log_weights(sample, drawn.filled, 0.0)
    log_posterior = importance_log_weights(sample, drawn.filled, 1.0)
    anchors = np.concatenate((inputs.anchors, drawn.candidates))
    groups = find_groups(
        states, log_posterior, config.cluster_radii, MOST_CLUSTERS, -math.inf, anchors
    )
    if groups.number == 0:
        return impossible_posterior(states, log_posterior)
    map_log_ratios = sample.map_log_ratios[: len(states)]
    particles = WeighedParticles(states, log_prior, log_posterior, sample.densities, map_log_ratios)
    corrected = corrected_clusters(particles, groups, inputs, config)
    clear = border_clearness(corrected.clusters.means, inputs.scan, inputs.model)
    log_odds = _log_odds(corrected, clear, sample, inputs, config)
    order = most_probable_first(corrected.clusters.masses, log_odds)
    hypotheses = _hypotheses(states, corrected, clear, order, sample, inputs)
    deviation = scaled_pose_distance(
        hypotheses.clusters.means[0], inputs.prior.expected[0], config.same_hypothesis_radii
    )
    return Conclusion(
        states,
        corrected.log_weights,
        hypotheses,
        log_odds[order],
        _p_bright(corrected.weights, sample, inputs),
        probability_of(log_odds[order[0]]),
        deviation,
        deviation < 1.0,
    )


class CorrectedClusters(NamedTuple):
    """Clusters of the particles after the correlation between frames has been corrected for.

    Attributes
    ----------
    log_weights, weights : FloatArray
        Corrected weights, normalised, and their logarithms, shape (N,).
    clusters : Clusters
        Clusters by these weights.
    background : Background
        What the clusters are held against.
    appearances : FloatArray
        How much the clusters look like cables, shape (K,) [nats].
    """

    log_weights: FloatArray
    weights: FloatArray
    clusters: Clusters
    background: Background
    appearances: FloatArray


@compiled_part
def corrected_clusters(
    particles: WeighedParticles, groups: Groups, inputs: FrameInputs, config: FrameConfig
) -> CorrectedClusters:
    """Correct the weights of the particles, and return their clusters.

    Parameters
    ----------
    particles : WeighedParticles
        The particles, angles in (-pi/2, pi/2].
    groups : Groups
        Groups of them by the posterior, at least one.
    inputs, config : FrameInputs, FrameConfig
        What they were drawn with.
    """
    states = particles.states
    background, appearances = _background_and_appearances(
        states, particles.log_posterior, groups, inputs, config
    )
    log_weights = normalise_log_weights(
        corrected_log_weights(particles, groups, background.alike, appearances, config)
    ).log_weights
    weights = exponentials(log_weights)
    clusters, order = clusters_of(states, weights, groups)
    if not len(clusters.masses):
        # Correcting may leave all groups light and the rest heavy: group by the corrected weights.
        groups = find_groups(
            states, log_weights, config.cluster_radii, MOST_CLUSTERS, -math.inf, states[:0]
        )
        background, appearances = _background_and_appearances(
            states, log_weights, groups, inputs, config
        )
        clusters, order = clusters_of(states, weights, groups)
    background = Background(
        background.alike[order], background.means[order], background.deviations[order]
    )
    return CorrectedClusters(log_weights, weights, clusters, background, appearances[order])


@compiled_part
def _background_and_appearances(
    states: FloatArray,
    log_weights: FloatArray,
    groups: Groups,
    inputs: FrameInputs,
    config: FrameConfig,
) -> tuple[Background, FloatArray]:
    """Return what groups of particles are held against, and how much they look like cables."""
    centres = group_centres(states, log_weights, groups)
    background = background_of(centres, inputs, config)
    return background, appearances_of(centres, inputs.scan, inputs.model, inputs.cable_map)


@compiled_part
def _hypotheses(
    states: FloatArray,
    corrected: CorrectedClusters,
    clear: BorderClearness,
    order: IndexArray,
    sample: Sample,
    inputs: FrameInputs,
) -> Hypotheses:
    """Return the clusters in an order, (K,), with what the frame measures of the first of it."""
    clusters, weights, leader = reordered(corrected.clusters, order), corrected.weights, order[0]
    border_mean, visible_length = _weaker_border_of_leader(clusters, weights, sample, inputs)
    return Hypotheses(
        clusters,
        group_covariance(
            states, weights, clusters.labels, 0, clusters.masses[0], clusters.means[0]
        ),
        effective_sample_size(corrected.log_weights),
        border_mean,
        visible_length,
        _borders_of_leading_mean(clusters.means, inputs),
        clear.clearness[leader] * shown_share(clear.shown[leader]),
        corrected.appearances[leader],
        is_worked_out(inputs.cable_map),
        map_match(clusters.means[0], inputs.cable_map).overlap_share,
    )


@compiled_part
def _wrapped_states(sample: Sample, end: int) -> FloatArray:
    """Return the first rows of a sample with angles in (-pi/2, pi/2]."""
    states = np.empty((end, STATE_SIZE))
    for row in range(end):
        state_in_chart(sample.states[row], 0.0, states[row])
    return states


@compiled_part
def impossible_posterior(states: FloatArray, log_posterior: FloatArray) -> Conclusion:
    """Return the conclusion without clusters: every particle is impossible."""
    labels = np.full(len(states), NO_CLUSTER, np.int64)
    none = np.empty(0)
    clusters = Clusters(labels, none, np.empty((0, STATE_SIZE)), 1.0)
    covariance = np.zeros((STATE_SIZE, STATE_SIZE))
    hypotheses = unmeasured_hypotheses(clusters, covariance, 0.0)
    return Conclusion(states, log_posterior, hypotheses, none, 0.0, 0.0, 0.0, False)


@compiled_loop
def _p_bright(weights: FloatArray, sample: Sample, inputs: FrameInputs) -> float:
    """Return the weighted share of bright cables among the particles."""
    p_bright = 0.0
    for row in range(len(weights)):
        p_bright += weights[row] * _bright_share_of(row, sample, inputs)
    return p_bright


@compiled_loop
def _weaker_border_of_leader(
    clusters: Clusters, weights: FloatArray, sample: Sample, inputs: FrameInputs
) -> tuple[float, float]:
    """Return the weaker border's mean and the visible length, over the leader.

    They are averages over its particles, each in its own polarity.
    """
    mass, measured = clusters.masses[0], sample.measured
    border_mean, length = 0.0, 0.0
    for row in range(len(weights)):
        if clusters.labels[row] == 0:
            is_bright = _bright_share_of(row, sample, inputs) >= 0.5
            left, right = measured.border_means[row, BRIGHT if is_bright else DARK]
            border_mean += weights[row] / mass * min(left, right)
            length += weights[row] / mass * measured.visible_lengths[row]
    return border_mean, length


@compiled_inside
def _bright_share_of(row: int, sample: Sample, inputs: FrameInputs) -> float:
    """Return the probability that a particle's cable is bright, and not a dark one."""
    log_ratios = sample.measured.log_ratios[row]
    return bright_share(inputs.polarity, log_ratios[BRIGHT], log_ratios[DARK])


@compiled_part
def _borders_of_leading_mean(means: FloatArray, inputs: FrameInputs) -> FloatArray:
    """Return the mean log-likelihood ratios (2,) of the first mean's borders."""
    measured = measured_cables(means[:1], inputs.scan, inputs.model)
    is_bright = measured.log_ratios[0, BRIGHT] >= measured.log_ratios[0, DARK]
    own: FloatArray = measured.border_means[0, BRIGHT if is_bright else DARK]
    return own


@compiled_part
def margins_and_scores(
    corrected: CorrectedClusters, sample: Sample
) -> tuple[FloatArray, FloatArray]:
    """Return the margin [nats] and the score [standard deviations] of each cluster, (K,) each.

    They are weighted means over its particles of the log-likelihood ratio above the best strip like
    it or `BEST_OF_ANY` deviations of strips of any kind, and above the mean of strips of any kind.
    """
    clusters, weights, background = corrected.clusters, corrected.weights, corrected.background
    count = len(clusters.masses)
    margins, scores = np.zeros(count), np.zeros(count)
    for row in range(len(weights)):
        label = clusters.labels[row]
        if label >= 0 and weights[row] > 0.0:
            share = weights[row] / clusters.masses[label]
            added = sample.densities.width_penalties[row] + sample.map_log_ratios[row]
            ratio = sample.log_likelihoods[row] - added
            mean, deviation = background.means[label], background.deviations[label]
            best = max(background.alike[label], mean + BEST_OF_ANY * deviation)
            margins[label] += share * (ratio - best)
            scores[label] += share * (ratio - mean) / deviation
    return margins, scores


@compiled_part
def _log_odds(
    corrected: CorrectedClusters,
    clear: BorderClearness,
    sample: Sample,
    inputs: FrameInputs,
    config: FrameConfig,
) -> FloatArray:
    """Return the log-odds (K,) that clusters are cables."""
    means, thin_width, prior = corrected.clusters.means, config.thin_width, inputs.prior
    margins, scores = margins_and_scores(corrected, sample)
    log_odds = np.empty(len(means))
    for index in range(len(means)):
        width, appearance = means[index, WIDTH], corrected.appearances[index]
        if not is_worked_out(inputs.cable_map):
            appearance = trusted_appearance(appearance, width, thin_width)
        # Any bottom has thin lines: what borders say of them counts less, for and against.
        factor = thin_factor(width, thin_width)
        frame_scores = FrameScores(
            factor * margins[index],
            factor * scores[index],
            clear.clearness[index],
            clear.shown[index],
            appearance,
        )
        radii = config.same_hypothesis_radii
        inherited = inherited_log_odds(prior, means[index], radii)
        is_known = config.is_known and is_same_hypothesis(means[index], prior.expected[0], radii)
        model = KNOWN_MODEL if is_known else MODEL
        log_odds[index] = updated_log_odds(inherited, frame_scores, prior, model)
    return log_odds
