"""The particles of a frame: drawn in rounds from several proposals, and weighed by the frame.

First survivors of the particles of the frame before, births, and cables about what a detector sees;
then, in rounds, particles about the best ones of the same frame, and about those that look most
like cables.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.predict.births import place_births
from cable_tracker.cable.hypotheses.predict.border_switch import place_switches
from cable_tracker.cable.hypotheses.predict.predicted_density import (
    LEAST_PROBABILITY,
    add_rates,
    choose_rates,
    fill_densities,
)
from cable_tracker.cable.hypotheses.propose.frame_inputs import FrameConfig, FrameInputs
from cable_tracker.cable.hypotheses.propose.peaks import (
    Peaks,
    add_detection_density,
    add_peak_densities,
    all_peaks,
    candidate_peaks,
    cluster_peaks,
    draw_about_peaks,
    no_peaks,
)
from cable_tracker.cable.hypotheses.propose.sample import (
    Sample,
    fill_log_likelihoods,
    importance_log_weights,
)
from cable_tracker.cable.hypotheses.weigh.clusters import find_groups, heaviest_members
from cable_tracker.cable.measure.borders.appearance import appearances_of
from cable_tracker.cable.measure.borders.likelihood_ratio import fill_measures
from cable_tracker.cable.measure.map.cable_map import map_log_ratio
from cable_tracker.cable.model.geometry import pose_in_chart, state_in_chart
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.compilation import compiled_part
from cable_tracker.particle_filter.particles import normalise_log_weights

CANDIDATE_SHARE = 0.5
"""Share of the particles of a round that are drawn about candidates."""

CANDIDATE_NARROWING = 0.5
"""Factor on the kernel scales of detections, for each round once more."""

MOST_LOOKED_AT, MOST_CANDIDATES = 12, 3
"""Numbers of particles that are looked at in a round, and of candidates among them and the strips
of the map."""


class Drawn(NamedTuple):
    """What has been drawn of a sample after some rounds.

    Attributes
    ----------
    filled : int
        Number of rows of the sample that are filled.
    centres : FloatArray
        d, alpha, w, beta that a detector sees, in the particles' chart [px, rad], shape (K, 4).
    peaks : Peaks
        What the rounds so far have drawn about.
    candidates : FloatArray
        Candidates of the last round, shape (C, 8): none beside a known cable, where the appearance
        does not count.
    """

    filled: int
    centres: FloatArray
    peaks: Peaks
    candidates: FloatArray


@compiled_part
def draw_sample(sample: Sample, inputs: FrameInputs, config: FrameConfig) -> Drawn:
    """Draw the particles of all rounds."""
    drawn = _draw_first(sample, inputs, config)
    for number in range(len(config.refined)):
        weights = normalise_log_weights(
            importance_log_weights(sample, drawn.filled, config.powers[number])
        )
        if config.refined[number] and not weights.degenerate:
            drawn = _draw_round(sample, drawn, weights.log_weights, number, inputs, config)
    return drawn


@compiled_part
def _draw_first(sample: Sample, inputs: FrameInputs, config: FrameConfig) -> Drawn:
    """Draw and measure survivors, births, border switches, and cables about detections."""
    counts, centres = inputs.counts, _poses_in_chart(inputs.detected, inputs.reference_angle)
    first = counts.survivors + counts.births
    end = first + counts.switches + counts.detections
    _place_first(sample.states, inputs, config, centres)
    fill_densities(sample.states, first, inputs.predicted, sample.densities)
    _measure(sample, inputs, config, 0, first)
    _draw_rates_and_measure(sample, inputs, config, first, end)
    drawn = Drawn(end, centres, no_peaks(), np.empty((0, STATE_SIZE)))
    _fill_proposal_density(sample, 0, drawn, inputs, config)
    return drawn


@compiled_part
def _draw_round(
    sample: Sample,
    before: Drawn,
    log_weights: FloatArray,
    number: int,
    inputs: FrameInputs,
    config: FrameConfig,
) -> Drawn:
    """Draw and measure the particles of a round, about the best ones so far and the candidates.

    Parameters
    ----------
    sample, before : Sample, Drawn
        The particles, and what of them was drawn in the rounds before.
    log_weights : FloatArray
        Log-weights of those that the round goes by, shape (`before.filled`,).
    number : int
        Number of the round, from 0.
    inputs, config : FrameInputs, FrameConfig
        What it is drawn with.
    """
    start, count = before.filled, config.refined[number]
    states, candidates = sample.states[:start], before.candidates
    if not config.is_known:
        log_likelihoods = sample.log_likelihoods[:start]
        candidates = likeliest_strips(states, log_likelihoods, inputs, config)
    share = int(CANDIDATE_SHARE * count) if len(candidates) else 0
    narrowing = CANDIDATE_NARROWING ** (number + 1)
    peaks = all_peaks(
        cluster_peaks(states, log_weights, count - share, config.widenings[number], config),
        candidate_peaks(candidates, share, narrowing, config),
    )
    draw_about_peaks(sample.states, start, inputs.noise, peaks)
    tail, density = config.degrees_of_freedom, sample.proposal_density
    add_peak_densities(states, 0, start, peaks, tail, density)
    _draw_rates_and_measure(sample, inputs, config, start, start + count)
    drawn = Drawn(start + count, before.centres, all_peaks(before.peaks, peaks), candidates)
    _fill_proposal_density(sample, start, drawn, inputs, config)
    return drawn


@compiled_part
def _poses_in_chart(poses: FloatArray, reference_angle: float) -> FloatArray:
    """Return poses (K, 4) with their normals within pi/2 of an angle [rad]."""
    chart = np.empty((len(poses), POSE_SIZE))
    for row in range(len(poses)):
        pose_in_chart(poses[row], reference_angle, chart[row])
    return chart


@compiled_part
def _place_first(
    states: FloatArray,
    inputs: FrameInputs,
    config: FrameConfig,
    centres: FloatArray,
) -> None:
    """Fill in the states of survivors and births, and the poses of the others of `_draw_first`."""
    predicted, noise, counts = inputs.predicted, inputs.noise, inputs.counts
    for row in range(counts.survivors):
        ancestor, factor = inputs.ancestors[row], noise.tail_factors[row, 0]
        for column in range(POSE_SIZE):
            spread = noise.normal[row, column] * factor * predicted.kernels.scales[column]
            states[row, column] = predicted.kernels.places[ancestor, column] + spread
        add_rates(states[row], row, ancestor, predicted, noise)
    first = counts.survivors + counts.births
    place_births(
        states, counts.survivors, first, counts.births_about_memory, predicted.births,
        noise.uniform, noise.about_memory,
    )  # fmt: skip
    for row in range(first):
        state_in_chart(states[row], inputs.reference_angle, states[row])
    switched = first + counts.switches
    place_switches(states, first, switched, predicted.border_switch, noise)
    for row in range(switched, switched + counts.detections):
        centre, factor = centres[(row - switched) % len(centres)], noise.tail_factors[row, 0]
        for column in range(POSE_SIZE):
            spread = noise.normal[row, column] * factor * config.detection_sigmas[column]
            states[row, column] = centre[column] + spread


@compiled_part
def _draw_rates_and_measure(
    sample: Sample, inputs: FrameInputs, config: FrameConfig, start: int, stop: int
) -> None:
    """Draw the rates of states whose poses were proposed, and fill in their log-likelihoods."""
    states = sample.states
    for row in range(start, stop):
        for column in range(POSE_SIZE, STATE_SIZE):
            states[row, column] = 0.0
        state_in_chart(states[row], inputs.reference_angle, states[row])
    choose_rates(states, start, stop, inputs.predicted, sample.densities, inputs.noise)
    _measure(sample, inputs, config, start, stop)


@compiled_part
def _measure(
    sample: Sample, inputs: FrameInputs, config: FrameConfig, start: int, stop: int
) -> None:
    fill_measures(
        sample.states,
        start,
        stop,
        inputs.scan,
        inputs.model,
        inputs.scan.points_across,
        sample.measured,
    )
    for row in range(start, stop):
        sample.map_log_ratios[row] = map_log_ratio(
            sample.states[row], inputs.cable_map, inputs.expected_overlap, config.map_weights
        )
    fill_log_likelihoods(sample, start, stop, inputs.polarity, config.limits, config.image_size)


@compiled_part
def _fill_proposal_density(
    sample: Sample, start: int, drawn: Drawn, inputs: FrameInputs, config: FrameConfig
) -> None:
    """Fill in the proposal density q, times the number of particles, from row `start` on.

    It is the sum over the proposals k of n_k q_k(x).
    """
    counts = inputs.counts
    births = float(counts.births) if counts.births else LEAST_PROBABILITY
    states, stop, density = sample.states, drawn.filled, sample.proposal_density
    for row in range(start, stop):
        density[row] = (
            counts.survivors * sample.densities.survivor_proposal[row]
            + births * sample.densities.birth_proposal[row]
            + counts.switches * sample.densities.border_switch[row]
        )
    if counts.detections:
        add_detection_density(
            states, start, stop, counts.detections, drawn.centres, config, density
        )
    add_peak_densities(states, start, stop, drawn.peaks, config.degrees_of_freedom, density)


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
