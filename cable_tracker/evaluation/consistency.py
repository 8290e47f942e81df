"""Whether errors are as large as the stated covariances say."""

from __future__ import annotations

from collections.abc import Iterable
from statistics import NormalDist

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import POSE_SIZE
from cable_tracker.evaluation.trace import Trace

REGION_NEES = 9.4877
"""95th percentile of the chi-square distribution of 4 degrees of freedom."""


def nees(errors: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return the normalised squared errors, shape (K,).

    Infinite where the covariance is no such thing: singular, or with a negative variance.

    Parameters
    ----------
    errors : FloatArray
        Shape (K, n).
    covariances : FloatArray
        Shape (K, n, n); finite.
    """
    result = np.full(len(errors), np.inf)
    for index, (error, covariance) in enumerate(zip(errors, covariances, strict=True)):
        sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        if not (sigma > 0.0).all():
            continue
        # px and rad differ by orders of magnitude; correlations do not.
        values, vectors = np.linalg.eigh(covariance / np.outer(sigma, sigma))
        if values[0] > 1e-12:
            result[index] = float(((vectors.T @ (error / sigma)) ** 2 / values).sum())
    return result


def coverage(traces: Iterable[Trace], nominal: FloatArray) -> FloatArray:
    """Return how often the truth lies inside the central interval of a nominal probability.

    Parameters
    ----------
    traces : iterable of Trace
        Runs whose claimed and visible frames are taken together.
    nominal : FloatArray
        Probabilities, each above 0 and below 1, shape (P,).

    Returns
    -------
    FloatArray
        Shares for d, alpha, w, beta, shape (P, 4); NaN if no frame is claimed.
    """
    ratios = _errors_in_sigmas(traces)
    if not len(ratios):
        return np.full((len(nominal), POSE_SIZE), np.nan)
    limits = np.array([central_limit(probability) for probability in nominal])
    shares: FloatArray = (ratios[None, :, :] <= limits[:, None, None]).mean(axis=1)
    return shares


def sigma_factors(traces: Iterable[Trace], probability: float) -> FloatArray:
    """Return by what sigma is to be multiplied to hold the share of the truths that it should.

    Parameters
    ----------
    traces : iterable of Trace
        Runs whose claimed and visible frames are taken together.
    probability : float
        The share, above 0 and below 1.

    Returns
    -------
    FloatArray
        Factors for d, alpha, w, beta, shape (4,): above 1 where sigma is too small; NaN if no frame
        is claimed.
    """
    ratios = _errors_in_sigmas(traces)
    if not len(ratios):
        return np.full(POSE_SIZE, np.nan)
    # An observed ratio, because one may be infinite.
    held: FloatArray = np.quantile(ratios, probability, axis=0, method="higher")
    return held / central_limit(probability)


def central_limit(probability: float) -> float:
    """Return how many sigma a Gaussian's central interval of that probability reaches."""
    return NormalDist().inv_cdf((1.0 + probability) / 2.0)


def _errors_in_sigmas(traces: Iterable[Trace]) -> FloatArray:
    """Return absolute errors over sigma of all claimed and visible frames, shape (K, 4)."""
    ratios = [np.full((0, POSE_SIZE), np.nan)]
    for trace in traces:
        chosen = trace.claimed & trace.visible
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios.append(np.abs(trace.errors[chosen]) / trace.sigmas[chosen])
    return np.concatenate(ratios)
