"""Frames are not independent evidence: the log-likelihood ratios of groups of particles, corrected.

Correlation between frames. Particles of one group compete by their likelihood; what is corrected is
the weight of each group as a whole. A group's log-likelihood ratio is log(posterior mass / prior
mass), less that of the bottom at its place, times `thin_factor`. Where no cable is known half of it
counts, the less the clearer the map is, and how much the group looks like a cable (`appearance`):
the bottom has stronger borders than a faint cable. Of a surviving group only `evidence_repeated`
times min(ratio, highest) is added: a furrow that is there in this frame is there in the next. Of a
new group: that part of the reference group's ratio plus ratio - reference ratio, clipped to
the range from -`evidence_limit` to highest. The reference is the surviving group of largest prior
mass. highest = `evidence_limit` plus the group's mean width penalty (<= 0): a width that is not the
one of before lowers it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.clusters import NO_CLUSTER, Groups
from cable_tracker.cable.hypotheses.frame_inputs import FrameConfig
from cable_tracker.cable.hypotheses.predicted_density import DensityValues
from cable_tracker.cable.hypotheses.presence import thin_factor
from cable_tracker.cable.model.state import WIDTH
from cable_tracker.compilation import compiled_loop, compiled_part
from cable_tracker.particle_filter.particles import masked_log_sum_exp

BACKGROUND_SHARE = 0.5
"""Share of the log-likelihood ratio above the background that counts where no cable is known.

Chosen on simulated worlds to tune on (`tune_*`)."""

FAINT_MAP, CLEAR_MAP = 4.0, 8.0
"""The share falls linearly from `BACKGROUND_SHARE` to 0 while the highest map log-ratio of any
particle rises from FAINT_MAP to CLEAR_MAP [nats]: a clear map is more reliable than borders, which
the bottom has, too."""

ORDINARY_APPEARANCE = 1.2
"""Appearance at which a group explains the frame no better than none [nats]."""

SURVIVED = 0.5
"""Least share of survivors of the frame before in the prior mass of a surviving group."""


class WeighedParticles(NamedTuple):
    """The N particles of a frame, and what they weigh.

    Attributes
    ----------
    states : FloatArray
        Shape (N, 8).
    log_prior, log_posterior : FloatArray
        Their log-weights before the frame is looked at and after, shape (N,) [nats].
    densities : DensityValues
        Their densities before the frame.
    map_log_ratios : FloatArray
        What the map of the frame added to their log-likelihoods, shape (N,) [nats]: of groups the
        appearance says it.
    """

    states: FloatArray
    log_prior: FloatArray
    log_posterior: FloatArray
    densities: DensityValues
    map_log_ratios: FloatArray


class GroupEvidence(NamedTuple):
    """What the frame says of K groups of particles, each of shape (K + 1,).

    Rows are addressed by label: the last one, -1, is that of the particles of no group.

    Attributes
    ----------
    log_ratio : FloatArray
        log(posterior mass / prior mass) [nats]; -inf for a group without posterior mass.
    counted : FloatArray
        share x `thin_factor` x (`log_ratio` - map - background), plus, where no cable is known, the
        appearance above `ORDINARY_APPEARANCE` [nats]; see `background_share`.
    survived_share : FloatArray
        Share of the prior mass that survived from the frame before, 0 to 1.
    width_penalty : FloatArray
        Mean width penalty over the posterior, at most 0 [nats].
    log_prior_mass : FloatArray
        Logarithm of the prior mass [nats]; -inf for a group without posterior mass.
    """

    log_ratio: FloatArray
    counted: FloatArray
    survived_share: FloatArray
    width_penalty: FloatArray
    log_prior_mass: FloatArray


@compiled_part
def corrected_log_weights(
    particles: WeighedParticles,
    groups: Groups,
    backgrounds: FloatArray,
    appearances: FloatArray,
    config: FrameConfig,
) -> FloatArray:
    """Return log-weights (N,) with the log-likelihood ratio of each of K groups corrected.

    `backgrounds`: log-likelihood ratio of the bottom at each of them, shape (K,), as
    `appearances` [nats]. Beside a known cable borders count whole, and appearance does not.
    """
    evidence = group_evidence(particles, groups, backgrounds, appearances, config)
    surviving = reference_group(evidence)
    reference = evidence.counted[surviving] if surviving != NO_CLUSTER else 0.0
    corrections = np.zeros(groups.number + 1)
    for label in range(NO_CLUSTER, groups.number):
        if evidence.log_ratio[label] != -np.inf:
            counted = counted_log_ratio(evidence, label, reference, config)
            corrections[label] = counted - evidence.log_ratio[label]
    corrected = np.empty(len(particles.log_posterior))
    for row in range(len(corrected)):
        corrected[row] = particles.log_posterior[row] + corrections[groups.labels[row]]
    return corrected


@compiled_part
def background_share(map_log_ratios: FloatArray, is_known: bool) -> float:
    """Return the share of the ratio above the background that counts.

    `map_log_ratios`, shape (N,), are those of the frame's particles [nats]. Where the appearance
    does not count, the map does not change what the borders say, either.
    """
    if is_known:
        return 1.0
    clearest: float = map_log_ratios.max()
    clear = (clearest - FAINT_MAP) / (CLEAR_MAP - FAINT_MAP)
    return BACKGROUND_SHARE * (1.0 - min(max(clear, 0.0), 1.0))


@compiled_part
def group_evidence(
    particles: WeighedParticles,
    groups: Groups,
    backgrounds: FloatArray,
    appearances: FloatArray,
    config: FrameConfig,
) -> GroupEvidence:
    """Sum up what the frame says of each group; see `corrected_log_weights`."""
    labels, count = groups.labels, groups.number + 1
    share = background_share(particles.map_log_ratios, config.is_known)
    evidence = GroupEvidence(
        np.full(count, -np.inf),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.full(count, -np.inf),
    )
    for label in range(NO_CLUSTER, groups.number):
        log_posterior_mass = masked_log_sum_exp(particles.log_posterior, labels, label)
        if log_posterior_mass == -math.inf:
            continue
        log_prior_mass = masked_log_sum_exp(particles.log_prior, labels, label)
        means = _means_of_group(particles, labels, label, log_prior_mass, log_posterior_mass)
        evidence.log_ratio[label] = log_posterior_mass - log_prior_mass
        ratio = log_posterior_mass - log_prior_mass - means.map_log_ratio
        background, appearance = 0.0, 0.0
        if label != NO_CLUSTER:
            background = backgrounds[label]
            appearance = appearances[label] - ORDINARY_APPEARANCE
        counted = share * (thin_factor(means.width, config.thin_width) * (ratio - background))
        if not config.is_known:
            counted += appearance
        evidence.counted[label] = counted
        evidence.survived_share[label] = min(means.survived_share, 1.0)
        evidence.width_penalty[label] = means.width_penalty
        evidence.log_prior_mass[label] = log_prior_mass
    return evidence


class _GroupMeans(NamedTuple):
    """Means over the particles of a group, by the posterior, but the survived share by the prior.

    `width` [px]; `width_penalty`, `map_log_ratio` [nats]; `survived_share` 0 to 1.
    """

    width: float
    width_penalty: float
    map_log_ratio: float
    survived_share: float


@compiled_loop
def _means_of_group(
    particles: WeighedParticles,
    labels: IndexArray,
    label: int,
    log_prior_mass: float,
    log_posterior_mass: float,
) -> _GroupMeans:
    densities = particles.densities
    width, penalty, survived, mapped = 0.0, 0.0, 0.0, 0.0
    for row in range(len(labels)):
        if labels[row] != label:
            continue
        share = math.exp(particles.log_posterior[row] - log_posterior_mass)
        penalty += share * densities.width_penalties[row]
        mapped += share * particles.map_log_ratios[row]
        width += share * particles.states[row, WIDTH]
        if densities.prior[row] > 0.0:
            kept = densities.prior_survival[row] / densities.prior[row]
            survived += math.exp(particles.log_prior[row] - log_prior_mass) * kept
    return _GroupMeans(width, penalty, mapped, survived)


@compiled_loop
def reference_group(evidence: GroupEvidence) -> int:
    """Return the label of the surviving group of largest prior mass; `NO_CLUSTER` if none is."""
    reference, heaviest = NO_CLUSTER, -np.inf
    for label in range(len(evidence.log_prior_mass) - 1):
        if evidence.survived_share[label] > SURVIVED and evidence.log_prior_mass[label] > heaviest:
            reference, heaviest = label, evidence.log_prior_mass[label]
    return reference


@compiled_loop
def counted_log_ratio(
    evidence: GroupEvidence, label: int, reference: float, config: FrameConfig
) -> float:
    """Return the log-likelihood ratio of a group that counts [nats].

    `reference` is the ratio above the background of the reference group, 0 without one [nats]. A
    group counts as surviving by its survived share, as new by the rest.
    """
    repeated, lowest = config.evidence_repeated, -config.evidence_limit
    highest = config.evidence_limit + evidence.width_penalty[label]
    ratio = evidence.counted[label]
    surviving = repeated * min(ratio, highest)
    new = repeated * min(reference, highest) + min(max(ratio - reference, lowest), highest)
    share = evidence.survived_share[label]
    return float(share * surviving + (1.0 - share) * new)
