"""Frame after frame is not independent evidence: how much of it counts.

Particles of one group compete by their likelihood. Between groups what counts is how well the frame
is explained. Of a group that goes on, a part counts in each frame: a furrow that is there in this
frame is there in the next. Of a new group all counts that it explains better than the heaviest of
those that go on, up to a limit, which is lower beside a cable that is known. A width that is not
the one of before lowers the limit: the clearest rope is no cable. Evidence for thin strips counts
less: any bottom has lines.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.clusters import NO_CLUSTER, Groups
from cable_tracker.cable.hypotheses.predicted_density import DensityValues
from cable_tracker.cable.hypotheses.presence import thin_factor
from cable_tracker.cable.model.state import WIDTH
from cable_tracker.compilation import compiled_part
from cable_tracker.particle_filter.weights import masked_log_sum_exp


class CorrectionRules(NamedTuple):
    """How much of the evidence for a group counts; see the parameters of the same names [px]."""

    evidence_limit: float
    evidence_repeated: float
    thin_width: float


@compiled_part
def corrected_weights(
    log_posterior: FloatArray,
    log_prior: FloatArray,
    states: FloatArray,
    densities: DensityValues,
    groups: Groups,
    backgrounds: FloatArray,
    rules: CorrectionRules,
) -> FloatArray:
    """Return log-weights (N,) with the evidence for each group corrected.

    Parameters
    ----------
    log_posterior, log_prior : FloatArray
        Log-weights of the particles after the frame and before it, shape (N,).
    states, densities : FloatArray, DensityValues
        The particles, shape (N, 8), and the densities that they had before the frame.
    groups : Groups
        Groups of the particles.
    backgrounds : FloatArray
        Log-likelihood ratio that the bottom explains at each group, shape (K,).
    rules : CorrectionRules
        Limits of the correction.
    """
    labels, count = groups.labels, groups.number + 1
    # The first is of the particles that belong to no group.
    group_log_ratio, log_ratio_above_background = np.full(count, -np.inf), np.zeros(count)
    survived, penalties = np.zeros(count), np.zeros(count)
    reference, heaviest = 0.0, -np.inf
    for group in range(count):
        label = group + NO_CLUSTER
        posterior_mass = masked_log_sum_exp(log_posterior, labels, label)
        if posterior_mass == -math.inf:
            continue
        prior_mass = masked_log_sum_exp(log_prior, labels, label)
        width = 0.0
        for row in range(len(labels)):
            if labels[row] != label:
                continue
            share = math.exp(log_posterior[row] - posterior_mass)
            penalties[group] += share * densities.width_penalties[row]
            width += share * states[row, WIDTH]
            if densities.prior[row] > 0.0:
                kept = densities.prior_survival[row] / densities.prior[row]
                survived[group] += math.exp(log_prior[row] - prior_mass) * kept
        survived[group] = min(survived[group], 1.0)
        group_log_ratio[group] = posterior_mass - prior_mass
        background = backgrounds[label] if label != NO_CLUSTER else 0.0
        log_ratio_above_background[group] = thin_factor(width, rules.thin_width) * (
            group_log_ratio[group] - background
        )
        if label != NO_CLUSTER and survived[group] > 0.5 and prior_mass > heaviest:
            reference, heaviest = log_ratio_above_background[group], prior_mass
    corrected = log_posterior.copy()
    limit = rules.evidence_limit
    for row in range(len(labels)):
        group = labels[row] - NO_CLUSTER
        if group_log_ratio[group] == -np.inf:
            continue
        highest = limit + penalties[group]
        old = rules.evidence_repeated * min(log_ratio_above_background[group], highest)
        better = min(max(log_ratio_above_background[group] - reference, -limit), highest)
        new = rules.evidence_repeated * min(reference, highest) + better
        share = survived[group]
        corrected[row] += share * old + (1.0 - share) * new - group_log_ratio[group]
    return corrected
