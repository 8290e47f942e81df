"""See the mixture sample and the filter in `cable_tracker.cable.hypotheses`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.compiled.clusters import (
    NONE,
    find_groups,
    group_covariance,
    group_means,
)
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.compiled.student_t import peak_density, tail


class Peaks(NamedTuple):
    """K Student-t proposals: number of particles drawn from each, location, Cholesky factor.

    Shapes (K,), (K, 4), (K, 4, 4).
    """

    counts: IndexArray
    locations: FloatArray
    factors: FloatArray


@compiled
def marginal_ratios(
    states: FloatArray,
    start: int,
    stop: int,
    log_ratios: FloatArray,
    bright: float,
    width_factors: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    marginal: FloatArray,
) -> None:
    """Fill in the log-likelihood ratios, polarity not known, width judged; -inf beyond limits."""
    log_bright, log_dark = math.log(bright), math.log1p(-bright)
    for row in range(start, stop):
        possible = True
        for column in range(4):
            value = states[row, column]
            possible = possible and lower[column] <= value <= upper[column]
        if not possible:
            marginal[row] = -math.inf
            continue
        first, second = log_bright + log_ratios[row, 0], log_dark + log_ratios[row, 1]
        higher, less = max(first, second), min(first, second)
        marginal[row] = higher + math.log1p(math.exp(less - higher)) + width_factors[row]


@compiled
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
            total += tail(a * a + b * b + c * c + d * d, degrees_of_freedom, 4)
        mixture[row] += factor * total


@compiled
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
            mixture[row] += factor * tail(squared, degrees_of_freedom, 4)


@compiled
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


@compiled
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
    weights = np.exp(log_shares)
    labels, count = find_groups(states, np.log(weights), image_width, np.empty((0, 8)))
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


@compiled
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


class Balance(NamedTuple):
    """How much of the evidence for a group counts; see the parameters of the same names."""

    evidence_of_bottom: float
    evidence_limit: float
    evidence_repeated: float


@compiled
def balance(
    log_posterior: FloatArray,
    log_prior: FloatArray,
    densities_full: FloatArray,
    densities_survived: FloatArray,
    width_factors: FloatArray,
    labels: IndexArray,
    count: int,
    rules: Balance,
) -> FloatArray:
    """Return balanced log-weights (N,), see the twin."""
    balanced = log_posterior.copy()
    for label in range(NONE, count):
        posterior_mass = _group_sum(log_posterior, labels, label)
        if posterior_mass == -math.inf:
            continue
        prior_mass = _group_sum(log_prior, labels, label)
        misfit, survived = 0.0, 0.0
        for row in range(len(labels)):
            if labels[row] != label:
                continue
            share = math.exp(log_posterior[row] - posterior_mass)
            misfit += share * width_factors[row]
            if densities_full[row] > 0.0:
                kept = densities_survived[row] / densities_full[row]
                survived += math.exp(log_prior[row] - prior_mass) * kept
        survived = min(survived, 1.0)
        evidence = posterior_mass - prior_mass
        new = min(evidence - rules.evidence_of_bottom, rules.evidence_limit + misfit)
        counted = new * (survived * rules.evidence_repeated + (1.0 - survived))
        for row in range(len(labels)):
            if labels[row] == label:
                balanced[row] += counted - evidence
    return balanced


@compiled
def _group_sum(values: FloatArray, labels: IndexArray, label: int) -> float:
    """Return log(sum(exp(values))) over a group; -inf for an empty one."""
    peak = -math.inf
    for row in range(len(labels)):
        if labels[row] == label:
            peak = max(peak, values[row])
    if peak == -math.inf:
        return peak
    total = 0.0
    for row in range(len(labels)):
        if labels[row] == label:
            total += math.exp(values[row] - peak)
    return peak + math.log(total)


@compiled
def summary(
    labels: IndexArray,
    leader: int,
    mass: float,
    weights: FloatArray,
    log_ratios: FloatArray,
    weaker: FloatArray,
    seen: FloatArray,
    bright: float,
) -> tuple[float, float, float]:
    """Return evidence and points seen over the leader, and how bright the cable is over all."""
    odds = math.log(bright) - math.log1p(-bright)
    evidence, points, brightness = 0.0, 0.0, 0.0
    for row in range(len(labels)):
        log_odds = odds + log_ratios[row, 0] - log_ratios[row, 1]
        share = 1.0 / (1.0 + math.exp(min(max(-log_odds, -700.0), 700.0)))
        brightness += weights[row] * share
        if labels[row] == leader:
            evidence += weights[row] / mass * (weaker[row, 0] if share >= 0.5 else weaker[row, 1])
            points += weights[row] / mass * seen[row]
    return evidence, points, brightness
