"""See `cable_tracker.particle_filter.weights`."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled, compiled_fast

SMALLEST_WEIGHT = 1e-250
"""Weights do not fall below this share of the largest: further down lie slow numbers, then zero."""


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


@compiled
def normalised(log_weights: FloatArray) -> tuple[FloatArray, bool]:
    """Return log-weights (N,) whose exponentials sum to one; uniform and True if none is positive.

    NaN counts as weight zero. Weights of plus infinity share the whole mass equally.
    """
    peak, infinite = -math.inf, 0
    for value in log_weights:
        if value == math.inf:
            infinite += 1
        elif value > peak:
            peak = value
    result = np.full(len(log_weights), -math.inf)
    if infinite:
        result[log_weights == math.inf] = -math.log(infinite)
        return result, False
    if peak == -math.inf:
        result[:] = -math.log(len(log_weights))
        return result, True
    total = 0.0
    for value in log_weights:
        if not math.isnan(value):
            total += math.exp(value - peak)
    for row in range(len(log_weights)):
        if not math.isnan(log_weights[row]):
            result[row] = log_weights[row] - peak - math.log(total)
    return result, False


@compiled
def effective_sample_size(log_weights: FloatArray) -> float:
    """Return N_eff = 1 / sum(weight^2) of normalised weights."""
    peak = log_weights.max()
    total, squares = 0.0, 0.0
    for value in log_weights:
        relative = math.exp(value - peak)
        total += relative
        squares += relative * relative
    return min(max(total * total / squares, 1.0), float(len(log_weights)))


@compiled_fast
def normalise(weights: FloatArray) -> float:
    """Scale positive weights (N,) in place to sum to one; return the effective sample size."""
    peak = 0.0
    for weight in weights:
        peak = max(peak, weight)
    total, squares = 0.0, 0.0
    for i in range(len(weights)):
        # By the largest first, so that equal weights give N without a rounding error.
        relative = max(weights[i] / peak, SMALLEST_WEIGHT)
        weights[i] = relative
        total += relative
        squares += relative * relative
    scale = 1.0 / total
    for i in range(len(weights)):
        weights[i] *= scale
    return min(max(total * total / squares, 1.0), float(len(weights)))
