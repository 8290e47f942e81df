"""A mixture of equal kernels about weighted centres: a cloud of particles as a density.

The kernels are Student-t of four components with a diagonal scale matrix. Evaluated in float32.
Centres are stored relative to the first centre in units of the scales, to avoid cancellation.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray
from cable_tracker.compilation import compiled_fast_loop
from cable_tracker.particle_filter.student_t import peak_density, relative_density

DIMENSIONS = 4

BLOCK = 32
"""Kernels per partial sum, when one of them is chosen by its share of the density."""


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
