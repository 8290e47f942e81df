"""Point estimates of weighted samples."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray


def weighted_mean(states: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighted mean, shape (k,), of states (N, k): the MMSE estimate.

    `weights` has shape (N,) and sums to one.
    """
    return weights @ states


def weighted_covariance(states: FloatArray, weights: FloatArray, mean: FloatArray) -> FloatArray:
    """Return the weighted covariance, shape (k, k), of states (N, k) about their mean (k,).

    Symmetric and positive semi-definite; zero for a single particle. It is the second central
    moment of the weighted sample, without a correction for the sample size.
    """
    deviations = states - mean
    covariance = (deviations * weights[:, None]).T @ deviations
    symmetric: FloatArray = (covariance + covariance.T) / 2
    return symmetric


def standard_deviations(covariance: FloatArray) -> FloatArray:
    """Return the square roots of a covariance's diagonal, shape (k,); 0 for what is below 0."""
    variances: FloatArray = np.maximum(np.diag(covariance), 0.0)
    return np.sqrt(variances)
