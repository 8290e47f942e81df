"""The particles of a frame: drawn in rounds from several proposals, and weighed by the frame.

First survivors of the particles of the frame before, births, and cables about what a detector sees;
then, in rounds, particles about the best ones of the same frame, and about those that look most
like cables.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.births import place_births
from cable_tracker.cable.hypotheses.border_switch import place_switches
from cable_tracker.cable.hypotheses.candidates import (
    CANDIDATE_NARROWING,
    CANDIDATE_SHARE,
    MOST_CANDIDATES,
    MOST_OF_MAP,
    likeliest_strips,
)
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise
from cable_tracker.cable.hypotheses.peaks import (
    MOST_REFINED,
    Peaks,
    add_candidate_peaks,
    add_cluster_peaks,
    add_detection_density,
    add_peak_densities,
    draw_about_peaks,
    empty_peaks,
)
from cable_tracker.cable.hypotheses.predicted_density import (
    LEAST_PROBABILITY,
    PredictedDensity,
    add_rates,
    choose_rates,
    fill_densities,
)
from cable_tracker.cable.hypotheses.proposal_config import ProposalConfig
from cable_tracker.cable.hypotheses.sample import (
    Sample,
    fill_log_likelihoods,
    fill_map_log_ratios,
    importance_log_weights,
)
from cable_tracker.cable.hypotheses.sample_counts import SampleCounts
from cable_tracker.cable.hypotheses.shadows import fill_shadow_losses, find_shadows
from cable_tracker.cable.measure.border_points import ScanInputs
from cable_tracker.cable.measure.cable_map import CableMap
from cable_tracker.cable.measure.likelihood_ratio import RatioModel, fill_log_ratios
from cable_tracker.cable.measure.map_strips import strips_of_map
from cable_tracker.cable.measure.polarity_prior import PolarityPrior
from cable_tracker.cable.model.geometry import pose_in_chart, state_in_chart
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.compilation import compiled_loop, compiled_part
from cable_tracker.particle_filter.weights import normalise_log_weights


class ProposalInputs(NamedTuple):
    """Inputs of the proposals that change with every frame.

    Attributes
    ----------
    predicted : PredictedDensity
        The density f before the frame is looked at.
    noise : FrameNoise
        Random numbers of the frame.
    scan, model : ScanInputs, RatioModel
        The scanned frame, and the tables of its log-likelihood ratios.
    cable_map : CableMap
        The map of the frame; `NO_MAP` beside a clear known cable, or if none is wanted.
    polarity : PolarityPrior
        Probability that a cable is brighter than the bottom.
    reference_angle : float
        Angle within pi/2 of which the normals of all particles are written [rad].
    ancestors : IndexArray
        Index of the kernel of f that each survivor is drawn from, shape (S,).
    detected : FloatArray
        d, alpha, w, beta of cables that a detector sees [px, rad], shape (K, 4).
    anchors : FloatArray
        Expected state of the leading cluster, shape (0 or 1, 8).
    """

    predicted: PredictedDensity
    noise: FrameNoise
    scan: ScanInputs
    model: RatioModel
    cable_map: CableMap
    polarity: PolarityPrior
    reference_angle: float
    ancestors: IndexArray
    detected: FloatArray
    anchors: FloatArray


@compiled_part
def draw_sample(
    sample: Sample, inputs: ProposalInputs, counts: SampleCounts, config: ProposalConfig
) -> tuple[int, FloatArray]:
    """Draw the particles of all rounds.

    How many there are is returned, and the candidates of the last round, shape (C, 8): none beside
    a known cable, where the appearance does not count.
    """
    centres = np.empty((len(inputs.detected), POSE_SIZE))
    _poses_in_chart(inputs.detected, inputs.reference_angle, centres)
    peaks = empty_peaks(len(counts.refined) * (MOST_REFINED + MOST_CANDIDATES))
    appearance_counts = not config.evidence_limits.is_known
    map_strips = strips_of_map(inputs.cable_map, MOST_OF_MAP if appearance_counts else 0)
    for strip in map_strips:
        state_in_chart(strip, inputs.reference_angle, strip)
    candidates = np.empty((0, STATE_SIZE))
    filled = _draw_first(sample, inputs, counts, config, centres)
    _apply_shadow_losses(sample, filled, inputs, config)
    _fill_proposal_density(sample, counts, config, 0, filled, centres, peaks, 0)
    used = 0
    for number in range(len(counts.refined)):
        count = counts.refined[number]
        weights = normalise_log_weights(
            importance_log_weights(sample, filled, config.powers[number])
        )
        if weights.degenerate or count == 0:
            continue
        states, stop = sample.states[:filled], filled + count
        if appearance_counts:
            candidates = likeliest_strips(
                states,
                sample.log_likelihoods[:filled],
                map_strips,
                inputs.scan,
                inputs.model,
                inputs.cable_map,
                config,
            )
        last = _add_peaks_of_round(
            states, weights.log_weights, candidates, number, count, config, peaks, used
        )
        draw_about_peaks(sample.states, filled, inputs.noise, peaks, used, last)
        tail, density = config.degrees_of_freedom, sample.proposal_density
        add_peak_densities(states, 0, filled, peaks, used, last, tail, density)
        used = last
        _draw_rates_and_measure(sample, inputs, config, filled, stop)
        _fill_proposal_density(sample, counts, config, filled, stop, centres, peaks, used)
        filled = stop
        _apply_shadow_losses(sample, filled, inputs, config)
    return filled, candidates


@compiled_part
def _add_peaks_of_round(
    states: FloatArray,
    log_weights: FloatArray,
    candidates: FloatArray,
    number: int,
    count: int,
    config: ProposalConfig,
    peaks: Peaks,
    used: int,
) -> int:
    """Add the peaks that round `number` draws `count` particles about; return how many there are.

    They are clusters of the particles so far, shapes (N, 8) and (N,), and the candidates (C, 8).
    """
    share = int(CANDIDATE_SHARE * count) if len(candidates) else 0
    widening, narrowing = config.widenings[number], CANDIDATE_NARROWING ** (number + 1)
    of_clusters = add_cluster_peaks(
        states, log_weights, count - share, widening, config, peaks, used
    )
    return add_candidate_peaks(candidates, share, narrowing, config, peaks, of_clusters)


@compiled_loop
def _poses_in_chart(poses: FloatArray, reference_angle: float, chart: FloatArray) -> None:
    """Write poses (K, 4) with their normals within pi/2 of an angle [rad] into `chart` (K, 4)."""
    for row in range(len(poses)):
        pose_in_chart(poses[row], reference_angle, chart[row])


@compiled_part
def _draw_first(
    sample: Sample,
    inputs: ProposalInputs,
    counts: SampleCounts,
    config: ProposalConfig,
    centres: FloatArray,
) -> int:
    """Draw and measure the particles of the first round, and return how many there are."""
    states, predicted, noise = sample.states, inputs.predicted, inputs.noise
    for row in range(counts.survivors):
        ancestor, stretch = inputs.ancestors[row], noise.stretches[row, 0]
        for column in range(POSE_SIZE):
            spread = noise.normal[row, column] * stretch * predicted.kernels.scales[column]
            states[row, column] = predicted.kernels.places[ancestor, column] + spread
        add_rates(states[row], row, ancestor, predicted, noise)
    first = counts.survivors + counts.births
    place_births(
        states, counts.survivors, first, counts.births_near_memory, predicted.births, noise
    )
    for row in range(first):
        state_in_chart(states[row], inputs.reference_angle, states[row])
    switched = first + counts.switches
    place_switches(states, first, switched, predicted.border_switch, noise)
    end = switched + counts.detections
    for row in range(switched, end):
        centre, stretch = centres[(row - switched) % len(centres)], noise.stretches[row, 0]
        for column in range(POSE_SIZE):
            spread = noise.normal[row, column] * stretch * config.detection_sigmas[column]
            states[row, column] = centre[column] + spread
    fill_densities(states, 0, first, predicted, sample.densities)
    _measure(sample, inputs, config, 0, first)
    _draw_rates_and_measure(sample, inputs, config, first, end)
    return end


@compiled_part
def _draw_rates_and_measure(
    sample: Sample, inputs: ProposalInputs, config: ProposalConfig, start: int, stop: int
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
    sample: Sample, inputs: ProposalInputs, config: ProposalConfig, start: int, stop: int
) -> None:
    fill_log_ratios(
        sample.states,
        start,
        stop,
        inputs.scan,
        inputs.model,
        inputs.scan.points_across,
        sample.measured,
    )
    fill_map_log_ratios(sample, start, stop, inputs.cable_map)
    for row in range(start, stop):
        sample.shadow_losses[row] = 0.0
    fill_log_likelihoods(sample, start, stop, inputs.polarity, config.limits, config.image_size)


@compiled_part
def _apply_shadow_losses(
    sample: Sample, filled: int, inputs: ProposalInputs, config: ProposalConfig
) -> None:
    """Find shadows among the first `filled` particles, and lower their log-likelihoods."""
    is_dark = inputs.polarity.log_dark > inputs.polarity.log_bright
    if config.evidence_limits.is_known and is_dark:
        return  # The known cable is no shadow.
    states, possible = sample.states[:filled], sample.log_likelihoods[:filled] > -np.inf
    count = find_shadows(states, possible, sample.measured, config.shadows, sample.shadows)
    changed = fill_shadow_losses(
        states,
        sample.measured,
        sample.shadows,
        count,
        config.shadows.unit,
        sample.shadow_losses,
    )
    if changed:
        fill_log_likelihoods(sample, 0, filled, inputs.polarity, config.limits, config.image_size)


@compiled_part
def _fill_proposal_density(
    sample: Sample,
    counts: SampleCounts,
    config: ProposalConfig,
    start: int,
    stop: int,
    centres: FloatArray,
    peaks: Peaks,
    used: int,
) -> None:
    """Fill in the proposal density q, times the number of particles, at rows `start` to `stop`.

    It is the sum over the proposals k of n_k q_k(x).
    """
    survivors = float(counts.survivors) if counts.survivors else LEAST_PROBABILITY
    births = float(counts.births) if counts.births else LEAST_PROBABILITY
    for row in range(start, stop):
        sample.proposal_density[row] = (
            survivors * sample.densities.survivor_proposal[row]
            + births * sample.densities.birth[row]
            + counts.switches * sample.densities.border_switch[row]
        )
    if counts.detections:
        add_detection_density(
            sample.states, start, stop, counts.detections, centres, config, sample.proposal_density
        )
    tail = config.degrees_of_freedom
    add_peak_densities(sample.states, start, stop, peaks, 0, used, tail, sample.proposal_density)
