"""The particles of a frame: drawn in rounds from several proposals, and weighed by the frame.

First survivors of the particles of the frame before, births, and cables about what a detector sees;
then, in rounds, particles about the best ones of the same frame.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.border_jump import place_jumps
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise
from cable_tracker.cable.hypotheses.mixture_sample import (
    Peaks,
    add_detections,
    add_peaks,
    find_peaks,
    log_weights,
    marginal_ratios,
)
from cable_tracker.cable.hypotheses.prior import (
    MINIMUM_DENSITY,
    Prior,
    PriorDensities,
    add_rates,
    choose_rates,
    empty_densities,
    weigh_by_prior,
)
from cable_tracker.cable.hypotheses.sample_counts import SampleCounts
from cable_tracker.cable.hypotheses.survival_and_birth import place_births
from cable_tracker.cable.measure.border_points import FrameScan
from cable_tracker.cable.measure.likelihood_ratio import (
    CableEvidence,
    RatioModel,
    empty_evidence,
    measure_into,
)
from cable_tracker.cable.model.geometry import unwrap_state
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.compilation import compiled_loop, compiled_part
from cable_tracker.particle_filter.weights import normalise_log_weights


class Sample(NamedTuple):
    """Room for the particles of a frame while they are drawn: N rows.

    `ratios` are those of the likelihood, polarity not known, `mixture` the density that the
    particles were drawn from times their number.
    """

    states: FloatArray
    densities: PriorDensities
    evidence: CableEvidence
    ratios: FloatArray
    mixture: FloatArray


class ProposalConfig(NamedTuple):
    """What does not change from frame to frame; `powers` and `widenings` are of each round."""

    image_size: tuple[float, float]
    degrees_of_freedom: float
    lower: FloatArray
    upper: FloatArray
    detection_sigmas: FloatArray
    smallest_sigmas: FloatArray
    powers: FloatArray
    widenings: FloatArray
    most_refined: int
    smallest_refined: float


class ProposalInputs(NamedTuple):
    """Proposal densities and likelihood of a frame; `detected` in px and rad, (K, 4)."""

    prior: Prior
    noise: FrameNoise
    scan: FrameScan
    model: RatioModel
    p_bright: float
    reference_angle: float
    ancestors: IndexArray
    detected: FloatArray


def empty_sample(count: int) -> Sample:
    """Return room for some particles."""
    return Sample(
        np.empty((count, STATE_SIZE)),
        empty_densities(count),
        empty_evidence(count),
        np.empty(count),
        np.empty(count),
    )


@compiled_part
def draw_sample(
    sample: Sample, inputs: ProposalInputs, counts: SampleCounts, config: ProposalConfig
) -> int:
    """Draw the particles of all rounds, and return how many there are."""
    centres = _in_chart(inputs.detected, inputs.reference_angle)
    peaks = _no_peaks(len(counts.refined) * config.most_refined)
    filled = _draw_first(sample, inputs, counts, config, centres, peaks)
    used = 0
    for number in range(len(counts.refined)):
        count = counts.refined[number]
        weights, _, degenerate = normalise_log_weights(
            log_weights(
                config.powers[number],
                sample.ratios[:filled],
                sample.densities.full[:filled],
                sample.mixture[:filled],
            )
        )
        if degenerate or count == 0:
            continue
        found = _peaks_of(sample.states[:filled], weights, number, count, config, used, peaks)
        _draw_about(sample.states, filled, inputs, peaks, used, found)
        add_peaks(
            sample.states, 0, filled, peaks, used, found, config.degrees_of_freedom, sample.mixture
        )
        used = found
        _complete(sample, inputs, config, filled, filled + count)
        _mix(sample, counts, config, filled, filled + count, centres, peaks, used)
        filled += count
    return filled


@compiled_part
def _no_peaks(most: int) -> Peaks:
    return Peaks(
        np.zeros(most, np.int64),
        np.empty((most, POSE_SIZE)),
        np.empty((most, POSE_SIZE, POSE_SIZE)),
    )


@compiled_part
def _in_chart(poses: FloatArray, reference_angle: float) -> FloatArray:
    """Write poses (K, 4) in the chart of the prior."""
    states, state = np.zeros(STATE_SIZE), np.empty(STATE_SIZE)
    centres = np.empty((len(poses), POSE_SIZE))
    for row in range(len(poses)):
        for column in range(POSE_SIZE):
            states[column] = poses[row, column]
        unwrap_state(states, reference_angle, state)
        for column in range(POSE_SIZE):
            centres[row, column] = state[column]
    return centres


@compiled_part
def _draw_first(
    sample: Sample,
    inputs: ProposalInputs,
    counts: SampleCounts,
    config: ProposalConfig,
    centres: FloatArray,
    peaks: Peaks,
) -> int:
    states, prior, noise = sample.states, inputs.prior, inputs.noise
    for row in range(counts.survivors):
        ancestor, stretch = inputs.ancestors[row], noise.stretches[row, 0]
        for column in range(POSE_SIZE):
            spread = noise.normal[row, column] * stretch * prior.kernels.scales[column]
            states[row, column] = prior.kernels.places[ancestor, column] + spread
        add_rates(states[row], row, ancestor, prior, noise)
    first = counts.survivors + counts.births
    place_births(states, counts.survivors, first, counts.remembered, prior.births, noise)
    for row in range(first):
        unwrap_state(states[row], inputs.reference_angle, states[row])
    jumped = first + counts.jumps
    place_jumps(states, first, jumped, prior.jump, noise)
    end = jumped + counts.detections
    for row in range(jumped, end):
        centre, stretch = centres[(row - jumped) % len(centres)], noise.stretches[row, 0]
        for column in range(POSE_SIZE):
            spread = noise.normal[row, column] * stretch * config.detection_sigmas[column]
            states[row, column] = centre[column] + spread
    weigh_by_prior(states, 0, first, prior, sample.densities)
    _measure(sample, inputs, config, 0, first)
    _complete(sample, inputs, config, first, end)
    _mix(sample, counts, config, 0, end, centres, peaks, 0)
    return end


@compiled_part
def _peaks_of(
    states: FloatArray,
    weights: FloatArray,
    number: int,
    count: int,
    config: ProposalConfig,
    used: int,
    peaks: Peaks,
) -> int:
    """Add what a round draws about to the peaks, and return how many there are now."""
    masses, locations, factors = find_peaks(
        states,
        weights,
        config.image_size[0],
        config.most_refined,
        config.smallest_refined,
        config.widenings[number],
        config.smallest_sigmas,
    )
    total, left = 0.0, count
    for index in range(len(masses)):
        total += masses[index]
    for index in range(len(masses)):
        peaks.counts[used + index] = int(count * (masses[index] / total))
        for column in range(POSE_SIZE):
            peaks.locations[used + index, column] = locations[index, column]
            for term in range(POSE_SIZE):
                peaks.factors[used + index, column, term] = factors[index, column, term]
        left -= peaks.counts[used + index]
    peaks.counts[used] += left
    return used + len(masses)


@compiled_loop
def _draw_about(
    states: FloatArray, start: int, inputs: ProposalInputs, peaks: Peaks, first: int, last: int
) -> None:
    normal, stretches = inputs.noise.normal, inputs.noise.stretches
    row = start
    for index in range(first, last):
        for _ in range(peaks.counts[index]):
            for column in range(POSE_SIZE):
                offset = 0.0
                for term in range(column + 1):
                    offset += peaks.factors[index, column, term] * normal[row, term]
                states[row, column] = peaks.locations[index, column] + offset * stretches[row, 0]
            row += 1


@compiled_part
def _complete(
    sample: Sample, inputs: ProposalInputs, config: ProposalConfig, start: int, stop: int
) -> None:
    """Draw the rates of states whose poses were proposed, and measure them."""
    states = sample.states
    for row in range(start, stop):
        for column in range(POSE_SIZE, STATE_SIZE):
            states[row, column] = 0.0
        unwrap_state(states[row], inputs.reference_angle, states[row])
    choose_rates(states, start, stop, inputs.prior, sample.densities, inputs.noise)
    _measure(sample, inputs, config, start, stop)


@compiled_part
def _measure(
    sample: Sample, inputs: ProposalInputs, config: ProposalConfig, start: int, stop: int
) -> None:
    measure_into(sample.states, start, stop, inputs.scan, inputs.model, sample.evidence)
    marginal_ratios(
        sample.states,
        start,
        stop,
        sample.evidence.log_ratios,
        inputs.p_bright,
        sample.densities.width_penalties,
        config.lower,
        config.upper,
        config.image_size,
        sample.ratios,
    )


@compiled_loop
def _mix(
    sample: Sample,
    counts: SampleCounts,
    config: ProposalConfig,
    start: int,
    stop: int,
    centres: FloatArray,
    peaks: Peaks,
    used: int,
) -> None:
    """Work out the density of the whole mixture at the rows from `start` to `stop`."""
    survivors = float(counts.survivors) if counts.survivors else MINIMUM_DENSITY
    births = float(counts.births) if counts.births else MINIMUM_DENSITY
    for row in range(start, stop):
        sample.mixture[row] = (
            survivors * sample.densities.survivors[row]
            + births * sample.densities.births[row]
            + counts.jumps * sample.densities.jumps[row]
        )
    tail = config.degrees_of_freedom
    if counts.detections:
        add_detections(
            sample.states,
            start,
            stop,
            float(counts.detections),
            centres,
            config.detection_sigmas,
            tail,
            sample.mixture,
        )
    add_peaks(sample.states, start, stop, peaks, 0, used, tail, sample.mixture)
