"""Frame after frame is not independent evidence: how much of it counts.

Particles of one group compete by their likelihood. Between groups, and for whether there is a cable
at all, what counts is how much better the frame is explained, less what any bottom explains as
well, up to a limit, and in full only once: a furrow that is there in this frame is there in the
next. A width that is not the one of before lowers the limit: the clearest rope is no cable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.clusters import NONE
from cable_tracker.compilation import compiled_part


class CorrectionRules(NamedTuple):
    """How much of the evidence for a group counts; see the parameters of the same names."""

    evidence_of_bottom: float
    evidence_limit: float
    evidence_repeated: float


@compiled_part
def corrected_weights(
    log_posterior: FloatArray,
    log_prior: FloatArray,
    densities_full: FloatArray,
    densities_survived: FloatArray,
    width_penalties: FloatArray,
    labels: IndexArray,
    count: int,
    rules: CorrectionRules,
) -> FloatArray:
    """Return log-weights (N,) with the evidence for each group corrected."""
    corrected = log_posterior.copy()
    for label in range(NONE, count):
        posterior_mass = _group_sum(log_posterior, labels, label)
        if posterior_mass == -math.inf:
            continue
        prior_mass = _group_sum(log_prior, labels, label)
        penalty, survived = 0.0, 0.0
        for row in range(len(labels)):
            if labels[row] != label:
                continue
            share = math.exp(log_posterior[row] - posterior_mass)
            penalty += share * width_penalties[row]
            if densities_full[row] > 0.0:
                kept = densities_survived[row] / densities_full[row]
                survived += math.exp(log_prior[row] - prior_mass) * kept
        survived = min(survived, 1.0)
        evidence = posterior_mass - prior_mass
        new = min(evidence - rules.evidence_of_bottom, rules.evidence_limit + penalty)
        counted = new * (survived * rules.evidence_repeated + (1.0 - survived))
        for row in range(len(labels)):
            if labels[row] == label:
                corrected[row] += counted - evidence
    return corrected


@compiled_part
def _group_sum(values: FloatArray, labels: IndexArray, label: int) -> float:
    """Return log(sum(exp(values))) over a group; -inf for an empty one."""
    peak = -math.inf
    for row in range(len(labels)):
        if labels[row] == label:
            peak = max(peak, values[row])
    if peak == -math.inf:
        return peak
    total = 0.0
    for row in range(len(labels)):
        if labels[row] == label:
            total += math.exp(values[row] - peak)
    return peak + math.log(total)
