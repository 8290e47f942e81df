"""Student-t proposals: about what a detector sees, and about the best particles of the frame."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.clusters import (
    MOST_CLUSTERS,
    find_groups,
    group_covariance,
    group_means,
    heaviest_members,
)
from cable_tracker.cable.hypotheses.frame_inputs import FrameConfig, FrameInputs, FrameNoise
from cable_tracker.cable.measure.borders.appearance import appearances_of
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    SKEW,
    WIDTH,
)
from cable_tracker.cholesky import cholesky_factor
from cable_tracker.compilation import compiled_loop, compiled_part
from cable_tracker.particle_filter.particles import exponentials
from cable_tracker.particle_filter.student_t import peak_density, relative_density

MOST_REFINED, LEAST_REFINED = 3, 0.02
"""Largest number of clusters that a round draws about, and their minimum mass (the heaviest is
always one)."""

MOST_LOOKED_AT, MOST_CANDIDATES = 12, 3
"""Numbers of particles that are looked at in a round, and of candidates among them and the strips
of the map."""


class Peaks(NamedTuple):
    """P proposals about the best particles.

    Attributes
    ----------
    counts : IndexArray
        Number of particles drawn from each, shape (P,).
    locations : FloatArray
        d, alpha, w, beta of their centres [px, rad], shape (P, 4).
    factors : FloatArray
        Lower Cholesky factors of their scale matrices, shape (P, 4, 4).
    """

    counts: IndexArray
    locations: FloatArray
    factors: FloatArray


@compiled_part
def no_peaks() -> Peaks:
    """Return no peak."""
    return _room_for_peaks(0)


@compiled_part
def _room_for_peaks(number: int) -> Peaks:
    """Return peaks whose places are to be filled in, of which no particle is drawn yet."""
    return Peaks(
        np.zeros(number, np.int64),
        np.empty((number, POSE_SIZE)),
        np.zeros((number, POSE_SIZE, POSE_SIZE)),
    )


@compiled_part
def all_peaks(first: Peaks, others: Peaks) -> Peaks:
    """Return the peaks of both, in this order."""
    return Peaks(
        np.concatenate((first.counts, others.counts)),
        np.concatenate((first.locations, others.locations)),
        np.concatenate((first.factors, others.factors)),
    )


@compiled_part
def cluster_peaks(
    states: FloatArray, log_weights: FloatArray, count: int, widening: float, config: FrameConfig
) -> Peaks:
    """Return the heaviest clusters of particles as peaks to draw about.

    Parameters
    ----------
    states, log_weights : FloatArray
        The particles of the rounds before, shapes (N, 8) and (N,).
    count : int
        Number of particles that are to be drawn about the peaks.
    widening : float
        Factor on the covariance of the clusters.
    config : FrameConfig
        Radii of the clusters, and the smallest kernel scales.
    """
    weights = exponentials(log_weights)
    # A group about a lighter particle would weigh less than `LEAST_REFINED`.
    least = math.log(LEAST_REFINED / len(states))
    groups = find_groups(
        states, log_weights, config.cluster_radii, MOST_CLUSTERS, least, states[:0]
    )
    order, masses, means = group_means(states, weights, groups)
    number = 1
    while number < min(MOST_REFINED, len(order)) and masses[number] >= LEAST_REFINED:
        number += 1
    peaks = _room_for_peaks(number)
    total = masses[:number].sum()
    for index in range(number):
        peaks.counts[index] = int(count * (masses[index] / total))
        mean = means[index, :POSE_SIZE]
        covariance = group_covariance(
            states, weights, groups.labels, order[index], masses[index], mean
        )
        covariance *= widening
        for row in range(POSE_SIZE):
            peaks.locations[index, row] = mean[row]
            covariance[row, row] += config.smallest_sigmas[row] ** 2
        cholesky_factor(covariance, peaks.factors[index])
    peaks.counts[0] += count - peaks.counts.sum()
    return peaks


@compiled_part
def candidate_peaks(strips: FloatArray, count: int, narrowing: float, config: FrameConfig) -> Peaks:
    """Return strips (C, 8) as peaks to draw about.

    Parameters
    ----------
    strips : FloatArray
        Centres of the peaks.
    count : int
        Number of particles that are to be drawn about them.
    narrowing : float
        Factor on the kernel scales of detections.
    config : FrameConfig
        Kernel scales of detections, and the smallest ones.
    """
    peaks = _room_for_peaks(len(strips))
    for index in range(len(strips)):
        # The first ones get what the division leaves over.
        peaks.counts[index] = (count + len(strips) - 1 - index) // len(strips)
        for row in range(POSE_SIZE):
            peaks.locations[index, row] = strips[index, row]
            sigma = narrowing * config.detection_sigmas[row]
            peaks.factors[index, row, row] = max(sigma, config.smallest_sigmas[row])
    return peaks


@compiled_loop
def draw_about_peaks(states: FloatArray, start: int, noise: FrameNoise, peaks: Peaks) -> None:
    """Draw the poses of particles about peaks, from row `start` on."""
    row = start
    for peak in range(len(peaks.counts)):
        for _ in range(peaks.counts[peak]):
            for column in range(POSE_SIZE):
                offset = 0.0
                for term in range(column + 1):
                    offset += peaks.factors[peak, column, term] * noise.normal[row, term]
                offset *= noise.tail_factors[row, 0]
                states[row, column] = peaks.locations[peak, column] + offset
            row += 1


@compiled_loop
def add_peak_densities(
    states: FloatArray,
    start: int,
    stop: int,
    peaks: Peaks,
    degrees_of_freedom: float,
    proposal_density: FloatArray,
) -> None:
    """Add the densities of peaks, each times its number of particles, to a proposal density."""
    constant = peak_density(degrees_of_freedom, POSE_SIZE)
    for index in range(len(peaks.counts)):
        if peaks.counts[index] == 0:
            continue
        place, f = peaks.locations[index], peaks.factors[index]
        factor = peaks.counts[index] * constant / (f[0, 0] * f[1, 1] * f[2, 2] * f[3, 3])
        for row in range(start, stop):
            state = states[row]
            a = (state[0] - place[0]) / f[0, 0]
            b = (state[1] - place[1] - f[1, 0] * a) / f[1, 1]
            c = (state[2] - place[2] - f[2, 0] * a - f[2, 1] * b) / f[2, 2]
            d = (state[3] - place[3] - f[3, 0] * a - f[3, 1] * b - f[3, 2] * c) / f[3, 3]
            squared = a * a + b * b + c * c + d * d
            proposal_density[row] += factor * relative_density(
                squared, degrees_of_freedom, POSE_SIZE
            )


@compiled_part
def add_detection_density(
    states: FloatArray,
    start: int,
    stop: int,
    count: int,
    centres: FloatArray,
    config: FrameConfig,
    proposal_density: FloatArray,
) -> None:
    """Add `count` times the density of equal kernels about centres (K, 4) to a proposal's."""
    scales, tail = config.detection_sigmas, config.degrees_of_freedom
    peak = peak_density(tail, POSE_SIZE) / (scales[0] * scales[1] * scales[2] * scales[3])
    factor = float(count) * peak / len(centres)
    # The distances of one state are worked out several at a time, component by component.
    places, squared = np.empty((POSE_SIZE, len(centres))), np.empty(len(centres))
    for index in range(len(centres)):
        for column in range(POSE_SIZE):
            places[column, index] = centres[index, column]
    for row in range(start, stop):
        state, total = states[row], 0.0
        for index in range(len(squared)):
            a = (state[DISTANCE] - places[DISTANCE, index]) / scales[DISTANCE]
            b = (state[ANGLE] - places[ANGLE, index]) / scales[ANGLE]
            c = (state[WIDTH] - places[WIDTH, index]) / scales[WIDTH]
            d = (state[SKEW] - places[SKEW, index]) / scales[SKEW]
            squared[index] = a * a + b * b + c * c + d * d
        for index in range(len(squared)):
            total += relative_density(squared[index], tail, POSE_SIZE)
        proposal_density[row] += factor * total


@compiled_part
def likeliest_strips(
    states: FloatArray,
    log_likelihoods: FloatArray,
    inputs: FrameInputs,
    config: FrameConfig,
) -> FloatArray:
    """Return the particles, and strips of the map, that look most like cables, shape (C, 8).

    The best one comes first. Of particles that lie together only the likeliest is looked at.

    A faint cable that a detector sees for the first time weighs next to nothing beside a furrow
    that has been followed for a while, and would be drawn about in no round. So a part of each
    round goes to these, whatever they weigh: what is drawn about them weighs what it weighs anyway.

    Parameters
    ----------
    states, log_likelihoods : FloatArray
        Particles, shape (N, 8), and their log-likelihood ratios, shape (N,); -inf for impossible
        ones.
    inputs : FrameInputs
        The scanned frame, the tables of its log-likelihood ratios, its map, and the strips that
        the map shows.
    config : FrameConfig
        Radii of the clusters.
    """
    groups = find_groups(
        states, log_likelihoods, config.cluster_radii, MOST_LOOKED_AT, -math.inf, states[:0]
    )
    strips = states[heaviest_members(log_likelihoods, groups)]
    strips = np.concatenate((strips, inputs.predicted.births.map_strips))
    order = np.argsort(-appearances_of(strips, inputs.scan, inputs.model, inputs.cable_map))
    return strips[order[:MOST_CANDIDATES]]
