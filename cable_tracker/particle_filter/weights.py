"""Weights of particles in log space."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.compilation import compiled, compiled_loop, compiled_part


class NormalisedWeights(NamedTuple):
    """Log-weights whose exponentials sum to one.

    Attributes
    ----------
    log_weights : FloatArray
        Normalised log-weights, shape (N,).
    degenerate : bool
        True when no particle had a positive weight. The weights are uniform then: an observation
        that excludes every particle says nothing about which of them is better.
    """

    log_weights: FloatArray
    degenerate: bool


@compiled_part
def exponentials(values: FloatArray) -> FloatArray:
    """Return exp(values), shape (N,). Within a kernel NumPy's own takes long to compile."""
    result = np.empty(len(values))
    for row in range(len(values)):
        result[row] = math.exp(values[row])
    return result


@compiled
def log_sum_exp(values: FloatArray) -> float:
    """Return log(sum(exp(values))) without overflow or underflow; -inf for weights all zero."""
    peak = -math.inf
    for value in values:
        peak = max(peak, value)
    if not math.isfinite(peak):
        return peak
    total = 0.0
    for value in values:
        total += math.exp(value - peak)
    return peak + math.log(total)


@compiled_loop
def masked_log_sum_exp(values: FloatArray, labels: IndexArray, label: int) -> float:
    """Return log(sum(exp(values))) over the rows of one label, shapes (N,); -inf for none."""
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


def uniform_log_weights(count: int) -> FloatArray:
    """Return `count` equal log-weights that sum to one."""
    return np.full(count, -np.log(count))


@compiled
def normalise_log_weights(log_weights: FloatArray) -> NormalisedWeights:
    """Scale weights to sum to one.

    NaN counts as weight zero. Weights of plus infinity share the whole mass equally.

    Parameters
    ----------
    log_weights : FloatArray
        Log-weights, shape (N,), N >= 1.
    """
    peak, infinite = -math.inf, 0
    for value in log_weights:
        if value == math.inf:
            infinite += 1
        elif value > peak:
            peak = value
    result = np.full(len(log_weights), -math.inf)
    if infinite:
        for row in range(len(log_weights)):
            if log_weights[row] == math.inf:
                result[row] = -math.log(infinite)
        return NormalisedWeights(result, False)
    if peak == -math.inf:
        for row in range(len(log_weights)):
            result[row] = -math.log(len(log_weights))
        return NormalisedWeights(result, True)
    total = 0.0
    for value in log_weights:
        if not math.isnan(value):
            total += math.exp(value - peak)
    log_total = math.log(total)
    for row in range(len(log_weights)):
        if not math.isnan(log_weights[row]):
            # The peak goes first: a sum beside a large peak would be rounded away.
            result[row] = log_weights[row] - peak - log_total
    return NormalisedWeights(result, False)


@compiled
def effective_sample_size(log_weights: FloatArray) -> float:
    """Return N_eff = 1 / sum(weight^2) of normalised weights (thesis, section 3.3.3).

    Between 1, when one particle has all the weight, and N, when all weights are equal.
    """
    # Relative to the largest weight, so that equal weights give N without a rounding error, which
    # would make a filter resample that has no reason to.
    peak = -math.inf
    for value in log_weights:
        peak = max(peak, value)
    total, squares = 0.0, 0.0
    for value in log_weights:
        relative = math.exp(value - peak)
        total += relative
        squares += relative * relative
    return min(max(total * total / squares, 1.0), float(len(log_weights)))
