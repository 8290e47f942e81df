"""Weights of particles in log space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class NormalisedWeights:
    """Log-weights whose exponentials sum to one.

    Attributes
    ----------
    log_weights : FloatArray
        Shape (N,).
    log_evidence : float
        Logarithm of the sum of the weights before they were normalised; -inf if degenerate, inf if
        a weight was infinite.
    degenerate : bool
        True when no particle had a positive weight. The weights are uniform then: an observation
        that excludes every particle says nothing about which of them is better.
    """

    log_weights: FloatArray
    log_evidence: float
    degenerate: bool


def log_sum_exp(values: FloatArray) -> float:
    """Return log(sum(exp(values))) without overflow or underflow; -inf for weights all zero."""
    peak = float(np.max(values))
    if not np.isfinite(peak):
        return peak
    with np.errstate(over="ignore"):
        return peak + float(np.log(np.sum(np.exp(values - peak))))


def uniform_log_weights(count: int) -> FloatArray:
    """Return `count` equal log-weights that sum to one."""
    return np.full(count, -np.log(count))


def normalise_log_weights(log_weights: FloatArray) -> NormalisedWeights:
    """Scale weights to sum to one.

    NaN counts as weight zero. Weights of plus infinity share the whole mass equally.

    Parameters
    ----------
    log_weights : FloatArray
        Shape (N,), N >= 1.
    """
    cleaned = np.where(np.isnan(log_weights), -np.inf, log_weights)
    infinite = np.isposinf(cleaned)
    if infinite.any():
        equal = uniform_log_weights(int(infinite.sum()))[0]
        return NormalisedWeights(np.where(infinite, equal, -np.inf), np.inf, False)
    peak = float(np.max(cleaned))
    if peak == -np.inf:
        return NormalisedWeights(uniform_log_weights(len(cleaned)), -np.inf, True)
    # The peak goes first: a sum beside a large peak would be rounded away.
    # A difference beyond the range of floats is -inf, which is what it means.
    with np.errstate(over="ignore"):
        relative = cleaned - peak
    total = log_sum_exp(relative)
    return NormalisedWeights(relative - total, peak + total, False)


def effective_sample_size(log_weights: FloatArray) -> float:
    """Return N_eff = 1 / sum(weight^2) of normalised weights (thesis, section 3.3.3).

    Between 1, when one particle has all the weight, and N, when all weights are equal.
    """
    # Relative to the largest weight, so that equal weights give N without a rounding error, which
    # would make a filter resample that has no reason to.
    relative = np.exp(log_weights - np.max(log_weights))
    size = np.sum(relative) ** 2 / np.sum(relative**2)
    return float(np.clip(size, 1.0, len(log_weights)))
