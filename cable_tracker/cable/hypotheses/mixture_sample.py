"""Weights of particles that were drawn from several proposals.

A particle weighs f L / q, where q is the density of the whole mixture of proposals times the number
of particles: no proposal is a second prior, wherever it comes from.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.clusters import find_groups, group_covariance, group_means
from cable_tracker.cable.measure.likelihood_ratio import marginal_log_ratio
from cable_tracker.cable.model.geometry import borders_cross_inside
from cable_tracker.compilation import compiled_loop, compiled_part
from cable_tracker.particle_filter.student_t import peak_density, relative_density
from cable_tracker.particle_filter.weights import exponentials


class Peaks(NamedTuple):
    """K Student-t proposals: number of particles drawn from each, location, Cholesky factor.

    Shapes (K,), (K, 4), (K, 4, 4).
    """

    counts: IndexArray
    locations: FloatArray
    factors: FloatArray


@compiled_loop
def marginal_ratios(
    states: FloatArray,
    start: int,
    stop: int,
    log_ratios: FloatArray,
    p_bright: float,
    width_penalties: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    image_size: tuple[float, float],
    marginal: FloatArray,
) -> None:
    """Fill in the log-likelihood ratios, polarity not known, width judged.

    -inf beyond the limits, and where the borders cross inside the image.
    """
    log_bright, log_dark = math.log(p_bright), math.log1p(-p_bright)
    for row in range(start, stop):
        possible = not borders_cross_inside(states[row], image_size)
        for column in range(4):
            value = states[row, column]
            possible = possible and lower[column] <= value <= upper[column]
        if not possible:
            marginal[row] = -math.inf
            continue
        first, second = log_bright + log_ratios[row, 0], log_dark + log_ratios[row, 1]
        marginal[row] = marginal_log_ratio(first, second) + width_penalties[row]


@compiled_loop
def add_detections(
    states: FloatArray,
    start: int,
    stop: int,
    count: float,
    centres: FloatArray,
    scales: FloatArray,
    degrees_of_freedom: float,
    mixture: FloatArray,
) -> None:
    """Add `count` times the density of equal kernels about centres (K, 4) to the mixture."""
    peak = peak_density(degrees_of_freedom, 4) / (scales[0] * scales[1] * scales[2] * scales[3])
    factor = count * peak / len(centres)
    for row in range(start, stop):
        total = 0.0
        for centre in centres:
            a = (states[row, 0] - centre[0]) / scales[0]
            b = (states[row, 1] - centre[1]) / scales[1]
            c = (states[row, 2] - centre[2]) / scales[2]
            d = (states[row, 3] - centre[3]) / scales[3]
            total += relative_density(a * a + b * b + c * c + d * d, degrees_of_freedom, 4)
        mixture[row] += factor * total


@compiled_loop
def add_peaks(
    states: FloatArray,
    start: int,
    stop: int,
    peaks: Peaks,
    first: int,
    last: int,
    degrees_of_freedom: float,
    mixture: FloatArray,
) -> None:
    """Add the densities of peaks, each times its number of particles, to the mixture."""
    constant = peak_density(degrees_of_freedom, 4)
    for index in range(first, last):
        if peaks.counts[index] == 0:
            continue
        place, f = peaks.locations[index], peaks.factors[index]
        factor = peaks.counts[index] * constant / (f[0, 0] * f[1, 1] * f[2, 2] * f[3, 3])
        for row in range(start, stop):
            a = (states[row, 0] - place[0]) / f[0, 0]
            b = (states[row, 1] - place[1] - f[1, 0] * a) / f[1, 1]
            c = (states[row, 2] - place[2] - f[2, 0] * a - f[2, 1] * b) / f[2, 2]
            d = (states[row, 3] - place[3] - f[3, 0] * a - f[3, 1] * b - f[3, 2] * c) / f[3, 3]
            squared = a * a + b * b + c * c + d * d
            mixture[row] += factor * relative_density(squared, degrees_of_freedom, 4)


@compiled_part
def log_weights(
    power: float, ratios: FloatArray, full: FloatArray, mixture: FloatArray
) -> FloatArray:
    """Return log(f L^power / q) of each particle, shape (N,)."""
    weights = np.empty(len(ratios))
    for row in range(len(ratios)):
        if full[row] <= 0.0 or mixture[row] <= 0.0:
            weights[row] = -math.inf
            continue
        # Zero times -inf, the ratio of what is impossible, is no number.
        ratio = power * ratios[row] if power > 0.0 else 0.0
        weights[row] = ratio + np.log(full[row] / mixture[row])
    return weights


@compiled_part
def find_peaks(
    states: FloatArray,
    log_shares: FloatArray,
    image_width: float,
    most: int,
    smallest_mass: float,
    widening: float,
    smallest_sigmas: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return masses (K,), means (K, 4) and factors (K, 4, 4) of the clusters to draw about."""
    weights = exponentials(log_shares)
    labels, count = find_groups(states, log_shares, image_width, np.empty((0, 8)))
    order, masses, means = group_means(states, weights, labels, count)
    number = 1
    while number < min(most, len(order)) and masses[number] >= smallest_mass:
        number += 1
    factors = np.zeros((number, 4, 4))
    for index in range(number):
        covariance = group_covariance(
            states, weights, labels, order[index], masses[index], means[index], 4
        )
        for row in range(4):
            for column in range(4):
                covariance[row, column] *= widening
            covariance[row, row] += smallest_sigmas[row] ** 2
        _cholesky(covariance, factors[index])
    return masses[:number], means[:number, :4].copy(), factors


@compiled_loop
def _cholesky(matrix: FloatArray, factor: FloatArray) -> None:
    """Fill in the lower factor (4, 4) of the leading block of a matrix."""
    for row in range(4):
        for column in range(row + 1):
            total = matrix[row, column]
            for index in range(column):
                total -= factor[row, index] * factor[column, index]
            if row == column:
                factor[row, row] = math.sqrt(total)
            else:
                factor[row, column] = total / factor[column, column]
