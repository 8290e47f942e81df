"""Frames are not independent evidence: the log-likelihood ratios of groups of particles, corrected.

Correlation between frames. Particles of one group compete by their likelihood; what is corrected is
the weight of each group as a whole. A group's log-likelihood ratio is log(posterior mass / prior
mass), less that of the bottom at its place, times `thin_factor`. Where no cable is known half of it
counts, the less the clearer the map is, and how much the group looks like a cable (`appearance`):
the bottom has stronger borders than a faint cable. Of a surviving group only `evidence_repeated`
times min(ratio, limit) is added: a furrow that is there in this frame is there in the next. Of a
new group: that part of the reference group's ratio plus min(ratio - reference ratio, limit). The
reference is the surviving group of largest prior mass. limit = `evidence_limit` plus the group's
mean width penalty (<= 0): a width that is not the one of before lowers it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.clusters import NO_CLUSTER, Groups
from cable_tracker.cable.hypotheses.predicted_density import DensityValues
from cable_tracker.cable.hypotheses.thin_strips import thin_factor
from cable_tracker.cable.model.state import WIDTH
from cable_tracker.compilation import compiled_loop, compiled_part
from cable_tracker.particle_filter.weights import masked_log_sum_exp

BACKGROUND_SHARE = 0.5
"""Share of the log-likelihood ratio above the background that counts where no cable is known.

Chosen on simulated worlds to tune on (`tune_*`)."""

FAINT_MAP, CLEAR_MAP = 4.0, 8.0
"""What the map of the frame says of the particle that it suits best, up to where that share is
whole, and from where on it is 0 [nats]. Where the map is clear, the appearance says more than the
borders, which the bottom has, too: of overgrown pipelines, to tune on, twice as many would be lost
to strips that share one border with them."""

ORDINARY_APPEARANCE = 1.2
"""Appearance at which a group explains the frame no better than none [nats]."""

SURVIVED = 0.5
"""Least share of survivors of the frame before in the prior mass of a surviving group."""


class EvidenceLimits(NamedTuple):
    """Limits of the correction.

    Attributes
    ----------
    evidence_limit : float
        Upper bound of the log-likelihood ratio of a group that counts [nats].
    evidence_repeated : float
        Share of the ratio of a surviving group that counts, 0 to 1.
    thin_width : float
        Width below which ratios count less [px of the frame].
    background_share, appearance_share : float
        Shares of the ratio above the background and of the appearance that count.
    """

    evidence_limit: float
    evidence_repeated: float
    thin_width: float
    background_share: float
    appearance_share: float


class GroupEvidence(NamedTuple):
    """What the frame says of K groups of particles, each of shape (K + 1,).

    Rows are addressed by label: the last one, -1, is that of the particles of no group.

    Attributes
    ----------
    log_ratio : FloatArray
        log(posterior mass / prior mass) [nats]; -inf for a group without posterior mass.
    counted : FloatArray
        Share of `log_ratio` less what the map adds and that of the bottom at the place of the
        group, times `thin_factor`, plus the share of the appearance above `ORDINARY_APPEARANCE`
        [nats].
    survived_share : FloatArray
        Share of the prior mass that survived from the frame before, 0 to 1.
    width_penalty : FloatArray
        Mean width penalty over the posterior, at most 0 [nats].
    prior_mass : FloatArray
        Logarithm of the prior mass [nats]; -inf for a group without posterior mass.
    """

    log_ratio: FloatArray
    counted: FloatArray
    survived_share: FloatArray
    width_penalty: FloatArray
    prior_mass: FloatArray


@compiled_part
def corrected_log_weights(
    log_posterior: FloatArray,
    log_prior: FloatArray,
    states: FloatArray,
    densities: DensityValues,
    map_log_ratios: FloatArray,
    groups: Groups,
    backgrounds: FloatArray,
    appearances: FloatArray,
    limits: EvidenceLimits,
) -> FloatArray:
    """Return log-weights (N,) with the log-likelihood ratio of each group corrected.

    Parameters
    ----------
    log_posterior, log_prior : FloatArray
        Log-weights of the particles after the frame and before it, shape (N,).
    states, densities : FloatArray, DensityValues
        The particles, shape (N, 8), and their densities before the frame.
    map_log_ratios : FloatArray
        What the map of the frame added to their log-likelihoods, shape (N,) or more [nats]: of
        groups the appearance says it.
    groups : Groups
        Groups of the particles.
    backgrounds : FloatArray
        Log-likelihood ratio of the bottom at each group, shape (K,) [nats].
    appearances : FloatArray
        Appearance of each group, shape (K,) [nats].
    limits : EvidenceLimits
        Limits of the correction.
    """
    limits = limits_beside_map(limits, map_log_ratios[: len(states)])
    found = group_evidence(
        log_posterior,
        log_prior,
        states,
        densities,
        map_log_ratios,
        groups,
        backgrounds,
        appearances,
        limits,
    )
    leader = reference_group(found)
    reference = found.counted[leader] if leader != NO_CLUSTER else 0.0
    corrections = np.zeros(groups.number + 1)
    for label in range(NO_CLUSTER, groups.number):
        if found.log_ratio[label] != -np.inf:
            counted = counted_log_ratio(found, label, reference, limits)
            corrections[label] = counted - found.log_ratio[label]
    corrected = np.empty(len(log_posterior))
    for row in range(len(corrected)):
        corrected[row] = log_posterior[row] + corrections[groups.labels[row]]
    return corrected


@compiled_part
def limits_beside_map(limits: EvidenceLimits, map_log_ratios: FloatArray) -> EvidenceLimits:
    """Return limits for a frame whose map adds some log-likelihood ratios to particles, (N,).

    Where the appearance does not count, the map does not change what the borders say, either.
    """
    share = limits.background_share
    if limits.appearance_share > 0.0:
        clear = (map_log_ratios.max() - FAINT_MAP) / (CLEAR_MAP - FAINT_MAP)
        share *= 1.0 - min(max(clear, 0.0), 1.0)
    return EvidenceLimits(
        limits.evidence_limit,
        limits.evidence_repeated,
        limits.thin_width,
        share,
        limits.appearance_share,
    )


@compiled_part
def group_evidence(
    log_posterior: FloatArray,
    log_prior: FloatArray,
    states: FloatArray,
    densities: DensityValues,
    map_log_ratios: FloatArray,
    groups: Groups,
    backgrounds: FloatArray,
    appearances: FloatArray,
    limits: EvidenceLimits,
) -> GroupEvidence:
    """Sum up what the frame says of each group; arguments as of `corrected_log_weights`."""
    labels, count = groups.labels, groups.number + 1
    found = GroupEvidence(
        np.full(count, -np.inf),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.full(count, -np.inf),
    )
    for label in range(NO_CLUSTER, groups.number):
        posterior_mass = masked_log_sum_exp(log_posterior, labels, label)
        if posterior_mass == -math.inf:
            continue
        prior_mass = masked_log_sum_exp(log_prior, labels, label)
        width, penalty, survived, mapped = 0.0, 0.0, 0.0, 0.0
        for row in range(len(labels)):
            if labels[row] != label:
                continue
            share = math.exp(log_posterior[row] - posterior_mass)
            penalty += share * densities.width_penalties[row]
            mapped += share * map_log_ratios[row]
            width += share * states[row, WIDTH]
            if densities.prior[row] > 0.0:
                kept = densities.prior_survival[row] / densities.prior[row]
                survived += math.exp(log_prior[row] - prior_mass) * kept
        background = backgrounds[label] if label != NO_CLUSTER else 0.0
        ratio = posterior_mass - prior_mass - mapped
        found.log_ratio[label] = posterior_mass - prior_mass
        above = thin_factor(width, limits.thin_width) * (ratio - background)
        appearance = appearances[label] - ORDINARY_APPEARANCE if label != NO_CLUSTER else 0.0
        found.counted[label] = (
            limits.background_share * above + limits.appearance_share * appearance
        )
        found.survived_share[label] = min(survived, 1.0)
        found.width_penalty[label] = penalty
        found.prior_mass[label] = prior_mass
    return found


@compiled_loop
def reference_group(found: GroupEvidence) -> int:
    """Return the label of the surviving group of largest prior mass; `NO_CLUSTER` if none is."""
    reference, heaviest = NO_CLUSTER, -np.inf
    for label in range(len(found.prior_mass) - 1):
        if found.survived_share[label] > SURVIVED and found.prior_mass[label] > heaviest:
            reference, heaviest = label, found.prior_mass[label]
    return reference


@compiled_loop
def counted_log_ratio(
    found: GroupEvidence, label: int, reference: float, limits: EvidenceLimits
) -> float:
    """Return the log-likelihood ratio of a group that counts [nats].

    `reference` is the ratio above the background of the reference group, 0 without one [nats]. A
    group counts as surviving by its survived share, as new by the rest.
    """
    limit, repeated = limits.evidence_limit, limits.evidence_repeated
    highest, ratio = limit + found.width_penalty[label], found.counted[label]
    surviving = repeated * min(ratio, highest)
    new = repeated * min(reference, highest) + min(max(ratio - reference, -limit), highest)
    share = found.survived_share[label]
    return float(share * surviving + (1.0 - share) * new)
