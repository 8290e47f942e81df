"""The rounds of a frame in one go; see `cable_tracker.cable.hypotheses.multi_hypothesis_filter`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.compiled.geometry import unwrap_state
from cable_tracker.cable.compiled.likelihood_ratio import Look, RatioArrays, measure_into
from cable_tracker.cable.compiled.mixture_sample import (
    Peaks,
    add_detections,
    add_peaks,
    find_peaks,
    log_weights,
    marginal_ratios,
)
from cable_tracker.cable.compiled.prior_density import (
    PriorArrays,
    PriorDensities,
    add_rates,
    choose_rates,
    empty_densities,
    place_births,
    weigh_by_prior,
)
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise
from cable_tracker.cable.hypotheses.prior_density import MINIMUM_DENSITY
from cable_tracker.cable.model.state import PLACES, STATE_SIZE
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.compiled.weights import normalised


class Sample(NamedTuple):
    """Room for the particles of a frame while they are drawn: N rows.

    `ratios` are those of the likelihood, polarity not known, `mixture` the density that the
    particles were drawn from times their number.
    """

    states: FloatArray
    densities: PriorDensities
    evidence: RatioArrays
    ratios: FloatArray
    mixture: FloatArray


class Rules(NamedTuple):
    """What does not change from frame to frame; `powers` and `widenings` are of each round."""

    image_width: float
    degrees_of_freedom: float
    lower: FloatArray
    upper: FloatArray
    detection_sigmas: FloatArray
    smallest_sigmas: FloatArray
    powers: FloatArray
    widenings: FloatArray
    most_refined: int
    smallest_refined: float


class Plan(NamedTuple):
    """How many particles are drawn from what; `refined` of each round."""

    survivors: int
    births: int
    remembered: int
    detections: int
    refined: IndexArray


class Frame(NamedTuple):
    """What the particles of a frame are drawn and weighed by."""

    prior: PriorArrays
    noise: FrameNoise
    look: Look
    bright: float
    reference_angle: float
    ancestors: IndexArray
    detected: FloatArray


def empty_sample(count: int) -> Sample:
    """Return room for some particles."""
    return Sample(
        np.empty((count, STATE_SIZE)),
        empty_densities(count),
        RatioArrays(np.empty((count, 2)), np.empty((count, 2)), np.empty(count)),
        np.empty(count),
        np.empty(count),
    )


@compiled
def draw_sample(sample: Sample, frame: Frame, plan: Plan, rules: Rules) -> int:
    """Draw the particles of all rounds, and return how many there are."""
    centres = _in_chart(frame.detected, frame.reference_angle)
    peaks = _no_peaks(len(plan.refined) * rules.most_refined)
    filled = _draw_first(sample, frame, plan, rules, centres, peaks)
    used = 0
    for number in range(len(plan.refined)):
        count = plan.refined[number]
        weights, degenerate = normalised(
            log_weights(
                rules.powers[number],
                sample.ratios[:filled],
                sample.densities.full[:filled],
                sample.mixture[:filled],
            )
        )
        if degenerate or count == 0:
            continue
        found = _peaks_of(sample.states[:filled], weights, number, count, rules, used, peaks)
        _draw_about(sample.states, filled, frame, peaks, used, found)
        add_peaks(
            sample.states, 0, filled, peaks, used, found, rules.degrees_of_freedom, sample.mixture
        )
        used = found
        _complete(sample, frame, rules, filled, filled + count)
        _mix(sample, plan, rules, filled, filled + count, centres, peaks, used)
        filled += count
    return filled


@compiled
def _no_peaks(most: int) -> Peaks:
    return Peaks(
        np.zeros(most, np.int64), np.empty((most, PLACES)), np.empty((most, PLACES, PLACES))
    )


@compiled
def _in_chart(places: FloatArray, reference_angle: float) -> FloatArray:
    """Write places (K, 4) in the chart of the prior."""
    states, state = np.zeros(STATE_SIZE), np.empty(STATE_SIZE)
    centres = np.empty((len(places), PLACES))
    for row in range(len(places)):
        states[:PLACES] = places[row]
        unwrap_state(states, reference_angle, state)
        centres[row] = state[:PLACES]
    return centres


@compiled
def _draw_first(
    sample: Sample, frame: Frame, plan: Plan, rules: Rules, centres: FloatArray, peaks: Peaks
) -> int:
    states, prior, noise = sample.states, frame.prior, frame.noise
    for row in range(plan.survivors):
        ancestor, stretch = frame.ancestors[row], noise.stretches[row, 0]
        for column in range(PLACES):
            spread = noise.normal[row, column] * stretch * prior.scales[column]
            states[row, column] = prior.places[ancestor, column] + spread
        add_rates(states[row], row, ancestor, prior, noise)
    first = plan.survivors + plan.births
    place_births(states, plan.survivors, first, plan.remembered, prior.births, noise)
    for row in range(first):
        unwrap_state(states[row].copy(), frame.reference_angle, states[row])
    end = first + plan.detections
    for row in range(first, end):
        centre, stretch = centres[(row - first) % len(centres)], noise.stretches[row, 0]
        for column in range(PLACES):
            spread = noise.normal[row, column] * stretch * rules.detection_sigmas[column]
            states[row, column] = centre[column] + spread
    weigh_by_prior(states, 0, first, prior, sample.densities)
    _look_at(sample, frame, rules, 0, first)
    _complete(sample, frame, rules, first, end)
    _mix(sample, plan, rules, 0, end, centres, peaks, 0)
    return end


@compiled
def _peaks_of(
    states: FloatArray,
    weights: FloatArray,
    number: int,
    count: int,
    rules: Rules,
    used: int,
    peaks: Peaks,
) -> int:
    """Add what a round draws about to the peaks, and return how many there are now."""
    masses, locations, factors = find_peaks(
        states,
        weights,
        rules.image_width,
        rules.most_refined,
        rules.smallest_refined,
        rules.widenings[number],
        rules.smallest_sigmas,
    )
    total, left = masses.sum(), count
    for index in range(len(masses)):
        peaks.counts[used + index] = int(count * (masses[index] / total))
        peaks.locations[used + index] = locations[index]
        peaks.factors[used + index] = factors[index]
        left -= peaks.counts[used + index]
    peaks.counts[used] += left
    return used + len(masses)


@compiled
def _draw_about(
    states: FloatArray, start: int, frame: Frame, peaks: Peaks, first: int, last: int
) -> None:
    normal, stretches = frame.noise.normal, frame.noise.stretches
    row = start
    for index in range(first, last):
        for _ in range(peaks.counts[index]):
            for column in range(PLACES):
                offset = 0.0
                for term in range(column + 1):
                    offset += peaks.factors[index, column, term] * normal[row, term]
                states[row, column] = peaks.locations[index, column] + offset * stretches[row, 0]
            row += 1


@compiled
def _complete(sample: Sample, frame: Frame, rules: Rules, start: int, stop: int) -> None:
    """Draw the rates of states whose places were proposed, and look at them."""
    states = sample.states
    for row in range(start, stop):
        states[row, PLACES:] = 0.0
        unwrap_state(states[row].copy(), frame.reference_angle, states[row])
    choose_rates(states, start, stop, frame.prior, sample.densities, frame.noise)
    _look_at(sample, frame, rules, start, stop)


@compiled
def _look_at(sample: Sample, frame: Frame, rules: Rules, start: int, stop: int) -> None:
    measure_into(sample.states, start, stop, frame.look, sample.evidence)
    marginal_ratios(
        sample.states,
        start,
        stop,
        sample.evidence.log_ratios,
        frame.bright,
        sample.densities.width_factors,
        rules.lower,
        rules.upper,
        sample.ratios,
    )


@compiled
def _mix(
    sample: Sample,
    plan: Plan,
    rules: Rules,
    start: int,
    stop: int,
    centres: FloatArray,
    peaks: Peaks,
    used: int,
) -> None:
    """Work out the density of the whole mixture at the rows from `start` to `stop`."""
    survivors = float(plan.survivors) if plan.survivors else MINIMUM_DENSITY
    births = float(plan.births) if plan.births else MINIMUM_DENSITY
    for row in range(start, stop):
        sample.mixture[row] = (
            survivors * sample.densities.survivors[row] + births * sample.densities.births[row]
        )
    tail = rules.degrees_of_freedom
    if plan.detections:
        add_detections(
            sample.states,
            start,
            stop,
            float(plan.detections),
            centres,
            rules.detection_sigmas,
            tail,
            sample.mixture,
        )
    add_peaks(sample.states, start, stop, peaks, 0, used, tail, sample.mixture)
