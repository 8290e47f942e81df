"""The particles of a frame: drawn in rounds from several proposals, and weighed by the frame.

First survivors of the particles of the frame before, births, and cables about what a detector sees;
then, in rounds, particles about the best ones of the same frame, and about those that look most
like cables.

The importance weight of a particle is f L / q: f the density before the frame, L the likelihood
ratio of the frame, q the density of the mixture of all proposals times the number of particles. So
no proposal acts as a second prior.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.births import place_births, place_switches
from cable_tracker.cable.hypotheses.frame_inputs import FrameConfig, FrameInputs, FrameNoise
from cable_tracker.cable.hypotheses.peaks import (
    Peaks,
    add_detection_density,
    add_peak_densities,
    all_peaks,
    candidate_peaks,
    cluster_peaks,
    draw_about_peaks,
    likeliest_strips,
    no_peaks,
)
from cable_tracker.cable.hypotheses.predicted_density import (
    LEAST_PROBABILITY,
    DensityValues,
    PredictedDensity,
    empty_densities,
    fill_densities,
    fill_densities_of,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import (
    BRIGHT,
    DARK,
    CableMeasures,
    PolarityPrior,
    allocate_measures,
    fill_measures,
    marginal_log_ratio,
)
from cable_tracker.cable.measure.map.cable_map import map_log_ratio
from cable_tracker.cable.model.geometry import borders_cross_inside, pose_in_chart, state_in_chart
from cable_tracker.cable.model.initial_state import between
from cable_tracker.cable.model.limits import StateLimits
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.compilation import compiled_inside, compiled_loop, compiled_part
from cable_tracker.particle_filter.particles import normalise_log_weights
from cable_tracker.particle_filter.student_t import choose_kernel

CANDIDATE_SHARE = 0.5
"""Share of the particles of a round that are drawn about candidates."""

CANDIDATE_NARROWING = 0.5
"""Factor on the kernel scales of detections, for each round once more."""


class Sample(NamedTuple):
    """Room for N particles of a frame.

    Attributes
    ----------
    states : FloatArray
        The particles, shape (N, 8), in the chart about one reference angle.
    densities : DensityValues
        Densities before the frame is looked at.
    measured : CableMeasures
        Log-likelihood ratios of the frame, for either polarity.
    map_log_ratios : FloatArray
        What the map of the frame adds, shape (N,); 0 without one [nats].
    log_likelihoods : FloatArray
        Log-likelihood ratios averaged over the polarity, plus `map_log_ratios` and the width
        penalties, shape (N,); -inf for impossible poses [nats].
    proposal_density : FloatArray
        Density q of the mixture of proposals that the particles were drawn from, times their
        number, shape (N,).
    """

    states: FloatArray
    densities: DensityValues
    measured: CableMeasures
    map_log_ratios: FloatArray
    log_likelihoods: FloatArray
    proposal_density: FloatArray


def empty_sample(count: int) -> Sample:
    """Return room for some particles."""
    return Sample(
        np.empty((count, STATE_SIZE)),
        empty_densities(count),
        allocate_measures(count),
        np.zeros(count),
        np.empty(count),
        np.empty(count),
    )


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
    place_switches(states, first, switched, predicted.border_switch, noise.normal, noise.uniform)
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


@compiled_loop
def fill_log_likelihoods(
    sample: Sample,
    start: int,
    stop: int,
    polarity: PolarityPrior,
    limits: StateLimits,
    image_size: tuple[float, float],
) -> None:
    """Fill in the log-likelihoods from `start` to `stop`.

    Impossible are poses beyond the limits, and those whose borders cross inside the image.
    """
    for row in range(start, stop):
        state, log_ratios = sample.states[row], sample.measured.log_ratios[row]
        possible = not borders_cross_inside(state, image_size)
        for column in range(POSE_SIZE):
            value = state[column]
            possible = possible and limits.lower[column] <= value <= limits.upper[column]
        if not possible:
            sample.log_likelihoods[row] = -math.inf
            continue
        ratio = marginal_log_ratio(polarity, log_ratios[BRIGHT], log_ratios[DARK])
        ratio += sample.map_log_ratios[row]
        sample.log_likelihoods[row] = ratio + sample.densities.width_penalties[row]


@compiled_part
def importance_log_weights(sample: Sample, count: int, power: float) -> FloatArray:
    """Return log(f L^power / q) of the first particles, shape (count,)."""
    weights = np.empty(count)
    for row in range(count):
        prior, proposal = sample.densities.prior[row], sample.proposal_density[row]
        if prior <= 0.0 or proposal <= 0.0:
            weights[row] = -math.inf
            continue
        # Zero times -inf, the ratio of what is impossible, is no number.
        ratio = power * sample.log_likelihoods[row] if power > 0.0 else 0.0
        weights[row] = ratio + np.log(prior / proposal)
    return weights


@compiled_loop
def choose_rates(
    states: FloatArray,
    start: int,
    stop: int,
    predicted: PredictedDensity,
    densities: DensityValues,
    noise: FrameNoise,
) -> None:
    """Fill in the densities at states whose poses were proposed, and draw their rates.

    An ancestor is drawn by how likely it would have moved there, and births and border switches by
    how likely they are there: those have the rates of the search.
    """
    births = predicted.births
    for row in range(start, stop):
        state = states[row]
        fill_densities_of(state, row, predicted, densities)
        new = (
            predicted.mass_born * densities.birth[row]
            + predicted.mass_switched * densities.border_switch[row]
        )
        total = densities.prior_survival[row] + new
        position = noise.uniform[row, 0] * total
        ancestor = choose_kernel(predicted.kernels, predicted.mass_survived, position)
        if ancestor >= 0:
            add_rates(state, row, ancestor, predicted, noise)
            continue
        for column in range(POSE_SIZE, STATE_SIZE):
            state[column] = between(
                births.box.lower[column], births.box.upper[column], noise.uniform[row, column]
            )


@compiled_inside
def add_rates(
    state: FloatArray, row: int, ancestor: int, predicted: PredictedDensity, noise: FrameNoise
) -> None:
    """Fill in the rates of the child of an ancestor, given how far it is from where that drifts."""
    factor = noise.tail_factors[row, 1]
    for column in range(POSE_SIZE):
        moved = state[column] - predicted.kernels.places[ancestor, column]
        spread = noise.normal[row, POSE_SIZE + column] * factor * predicted.rate_scales[column]
        changed = predicted.rate_gains[column] * moved + spread
        state[POSE_SIZE + column] = predicted.rates[ancestor, column] + changed
