"""Means and covariances through functions that are not linear."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray


def sigma_points(mean: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return 2n points, equally weighted, that have a mean (n,) and a covariance (n, n).

    Shape (2n, n). Polynomials of up to the third degree keep their mean exactly.

    References
    ----------
    I. Arasaratnam and S. Haykin (2009), "Cubature Kalman filters".
    """
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    unit = np.where(sigma > 0.0, sigma, 1.0)
    # px and rad differ by orders of magnitude; correlations do not.
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    root = unit[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    steps = np.sqrt(len(mean)) * root.T
    return np.concatenate((mean + steps, mean - steps))


def mean_and_covariance(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return mean (k,) and covariance (k, k) of equally weighted points (N, k)."""
    mean = points.mean(axis=0)
    offsets = points - mean
    return mean, offsets.T @ offsets / len(points)
