"""The multivariate Student-t distribution: a Gaussian with heavy tails.

A draw is a Gaussian one divided by the square root of a chi-square over its degrees of freedom, the
same for all components: in most frames everything moves a little, now and then everything jumps.
Infinite degrees of freedom make it Gaussian.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray


def student_t_stretches(
    rng: np.random.Generator, rows: int, count: int, degrees_of_freedom: float
) -> FloatArray:
    """Draw the factors that make Student-t numbers of normal ones, shape (rows, count).

    Of shape (rows, 0) for infinite degrees of freedom: none are needed.
    """
    if math.isinf(degrees_of_freedom):
        return np.empty((rows, 0))
    chi_squares = rng.chisquare(degrees_of_freedom, (rows, count))
    stretches: FloatArray = np.sqrt(degrees_of_freedom / chi_squares)
    return stretches


def standard_student_t(
    rng: np.random.Generator, count: int, dimensions: int, degrees_of_freedom: float
) -> FloatArray:
    """Draw from the distribution of location zero and unit scale, shape (count, dimensions)."""
    normal = rng.standard_normal((count, dimensions))
    stretches = student_t_stretches(rng, 1, count, degrees_of_freedom)
    return normal * stretches.T if stretches.size else normal


def student_t_log_density(
    squared_distances: FloatArray,
    dimensions: int,
    degrees_of_freedom: float,
    log_determinant: float,
) -> FloatArray:
    """Return the log-density at given squared Mahalanobis distances, of the same shape.

    `log_determinant` is that of the Cholesky factor of the scale matrix.
    """
    n, nu = dimensions, degrees_of_freedom
    if math.isinf(nu):
        constant = -0.5 * n * math.log(2 * math.pi) - log_determinant
        return constant - 0.5 * squared_distances
    constant = (
        math.lgamma((nu + n) / 2)
        - math.lgamma(nu / 2)
        - 0.5 * n * math.log(nu * math.pi)
        - log_determinant
    )
    return constant - 0.5 * (nu + n) * np.log1p(squared_distances / nu)


@dataclass(frozen=True, slots=True, eq=False)
class StudentT:
    """A multivariate Student-t distribution.

    Attributes
    ----------
    location : FloatArray
        Shape (k,).
    factor : FloatArray
        Lower Cholesky factor of the scale matrix, shape (k, k).
    degrees_of_freedom : float
        Above 0; infinite for a Gaussian.
    """

    location: FloatArray
    factor: FloatArray
    degrees_of_freedom: float

    def placed(self, standard: FloatArray) -> FloatArray:
        """Return the points for draws (N, k) of location zero and unit scale, shape (N, k)."""
        return self.location + standard @ self.factor.T

    def log_density(self, points: FloatArray) -> FloatArray:
        """Return the log-density at points (N, k), shape (N,)."""
        standard = np.linalg.solve(self.factor, (points - self.location).T)
        return student_t_log_density(
            (standard**2).sum(axis=0),
            len(self.location),
            self.degrees_of_freedom,
            float(np.log(np.diag(self.factor)).sum()),
        )
