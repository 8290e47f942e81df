"""The multivariate Student-t, a Gaussian with heavy tails, and mixtures of its kernels.

A draw is a Gaussian one divided by the square root of a chi-square over its degrees of freedom, the
same for all components: in most frames everything moves a little, now and then everything jumps.
Infinite degrees of freedom make it Gaussian.

A mixture of equal kernels about weighted centres is a cloud of particles as a density. Its kernels
are of four components with a diagonal scale matrix, evaluated in float32. Centres are stored
relative to the first centre in units of the scales, to avoid cancellation.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray
from cable_tracker.compilation import compiled, compiled_fast_loop, compiled_inside

DIMENSIONS = 4

BLOCK = 32
"""Kernels per partial sum, when one of them is chosen by its share of the density."""


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


class KernelMixture(NamedTuple):
    """M kernels with weights.

    Attributes
    ----------
    places : FloatArray
        The centres, shape (M, 4).
    scales : FloatArray
        Scales of the kernels, shape (4,); positive.
    degrees_of_freedom : float
        Degrees of freedom of the kernels; infinite for Gaussian ones.
    peak : float
        Density of a kernel at its centre.
    relative : Float32Array
        The centres from the first one, over the scales, float32, shape (4, M).
    weights : Float32Array
        Weights that sum to one, float32, shape (M,).
    values : Float32Array
        Room for the kernels at one point, over their peak, float32, shape (M,).
    """

    places: FloatArray
    scales: FloatArray
    degrees_of_freedom: float
    peak: float
    relative: Float32Array
    weights: Float32Array
    values: Float32Array


def kernel_mixture(
    places: FloatArray, scales: FloatArray, degrees_of_freedom: float, weights: FloatArray
) -> KernelMixture:
    """Return kernels about places (M, 4) with weights (M,)."""
    return KernelMixture(
        places=places,
        scales=scales,
        degrees_of_freedom=degrees_of_freedom,
        peak=peak_density(degrees_of_freedom, DIMENSIONS) / math.prod(scales.tolist()),
        relative=np.ascontiguousarray(((places - places[0]) / scales).T, np.float32),
        weights=weights.astype(np.float32),
        values=np.empty(len(weights), np.float32),
    )


@compiled_fast_loop
def evaluate_kernels(mixture: KernelMixture, point: FloatArray) -> None:
    """Fill in the values of the kernels at a point (4 or more,)."""
    kernels = mixture.values
    origin, scales = mixture.places[0], mixture.scales
    first, second, third, fourth = (
        np.float32((point[0] - origin[0]) / scales[0]),
        np.float32((point[1] - origin[1]) / scales[1]),
        np.float32((point[2] - origin[2]) / scales[2]),
        np.float32((point[3] - origin[3]) / scales[3]),
    )
    ones, twos, threes, fours = (
        mixture.relative[0], mixture.relative[1], mixture.relative[2], mixture.relative[3],
    )  # fmt: skip
    if mixture.degrees_of_freedom == 4.0:
        one, quarter = np.float32(1.0), np.float32(0.25)
        for index in range(len(kernels)):
            a, b = first - ones[index], second - twos[index]
            c, d = third - threes[index], fourth - fours[index]
            base = one + quarter * (a * a + b * b + c * c + d * d)
            square = base * base
            kernels[index] = one / (square * square)
    else:
        for index in range(len(kernels)):
            a, b = first - ones[index], second - twos[index]
            c, d = third - threes[index], fourth - fours[index]
            squared = a * a + b * b + c * c + d * d
            kernels[index] = relative_density(squared, mixture.degrees_of_freedom, 4)


@compiled_fast_loop
def weighted_sums(mixture: KernelMixture) -> tuple[float, float]:
    """Return the sum of the kernels' values by their weights, and the mean of the values."""
    kernels = mixture.values
    first, second = np.float32(0.0), np.float32(0.0)
    for index in range(len(kernels)):
        first += mixture.weights[index] * kernels[index]
        second += kernels[index]
    return float(first), float(second) / len(kernels)


@compiled_fast_loop
def choose_kernel(mixture: KernelMixture, factor: float, position: float) -> int:
    """Return which kernel a position in their densities times `factor` falls on; -1 for none."""
    left: float | np.float32 = position / (factor * mixture.peak)
    for start in range(0, len(mixture.values), BLOCK):
        weights, values = (
            mixture.weights[start : start + BLOCK],
            mixture.values[start : start + BLOCK],
        )
        # Sums are taken many at a time; one by one only where the position falls.
        total = np.float32(0.0)
        for index in range(len(values)):
            total += weights[index] * values[index]
        if left < total:
            for index in range(len(values)):
                left -= weights[index] * values[index]
                if left < 0.0:
                    return start + index
            return start + len(values) - 1
        left -= total
    return -1
