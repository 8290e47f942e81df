"""The multivariate Student-t distribution: a Gaussian with heavy tails.

A draw is a Gaussian one divided by the square root of a chi-square over its degrees of freedom, the
same for all components: in most frames everything moves a little, now and then everything jumps.
Infinite degrees of freedom make it Gaussian.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled, compiled_inside


def student_t_factors(
    rng: np.random.Generator, count: int, columns: int, degrees_of_freedom: float
) -> FloatArray:
    """Draw the factors that make Student-t numbers of normal ones, shape (count, columns)."""
    if math.isinf(degrees_of_freedom):
        return np.ones((count, columns))
    chi_squares = rng.chisquare(degrees_of_freedom, (count, columns))
    factors: FloatArray = np.sqrt(degrees_of_freedom / chi_squares)
    return factors


def standard_student_t(
    rng: np.random.Generator, count: int, dimensions: int, degrees_of_freedom: float
) -> FloatArray:
    """Draw from the distribution of location zero and unit scale, shape (count, dimensions)."""
    normal = rng.standard_normal((count, dimensions))
    return normal * student_t_factors(rng, count, 1, degrees_of_freedom)


@compiled_inside
def relative_log_density(
    squared_distance: float, degrees_of_freedom: float, dimensions: int
) -> float:
    """Return the log-density over its peak at a squared Mahalanobis distance."""
    if math.isinf(degrees_of_freedom):
        return -0.5 * squared_distance
    exponent = -0.5 * (degrees_of_freedom + dimensions)
    return exponent * math.log1p(squared_distance / degrees_of_freedom)


@compiled_inside
def relative_density(squared_distance: float, degrees_of_freedom: float, dimensions: int) -> float:
    """Return the density over its peak at a squared Mahalanobis distance."""
    if math.isinf(degrees_of_freedom):
        return math.exp(-0.5 * squared_distance)
    if degrees_of_freedom == 4.0 and dimensions in (1, 4):
        base = 1.0 + 0.25 * squared_distance
        square = base * base
        return 1.0 / (square * (square if dimensions == 4 else math.sqrt(base)))
    return math.exp(relative_log_density(squared_distance, degrees_of_freedom, dimensions))


@compiled_inside
def log_peak_density(degrees_of_freedom: float, dimensions: int) -> float:
    """Return the log-density at the location for a unit scale; degrees of freedom are finite."""
    return (
        math.lgamma((degrees_of_freedom + dimensions) / 2)
        - math.lgamma(degrees_of_freedom / 2)
        - 0.5 * dimensions * math.log(degrees_of_freedom * math.pi)
    )


@compiled
def peak_density(degrees_of_freedom: float, dimensions: int) -> float:
    """Return the density at the location for a unit scale."""
    if math.isinf(degrees_of_freedom):
        return math.pow(2.0 * math.pi, -0.5 * dimensions)
    return math.exp(log_peak_density(degrees_of_freedom, dimensions))
