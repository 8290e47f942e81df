"""See the prior density, and for the births leaving, in `cable_tracker.cable.hypotheses`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.compiled.geometry import turn_sign, wrapped_angle
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise
from cable_tracker.cable.hypotheses.leaving import MOST_TURNS, TAIL
from cable_tracker.cable.hypotheses.prior_density import MINIMUM_DENSITY, Prior
from cable_tracker.cable.hypotheses.usual_width import TAIL as WIDTH_TAIL
from cable_tracker.cable.model.state import PLACES, STATE_SIZE
from cable_tracker.compilation import compiled, compiled_fast, compiled_inside
from cable_tracker.particle_filter.compiled.student_t import peak_density, tail

BIRTH_PEAK = (
    math.gamma((TAIL + 1.0) / 2) / math.gamma(TAIL / 2) / math.sqrt(TAIL * math.pi)
) ** PLACES


class BirthArrays(NamedTuple):
    """The density of births: a box, and about a remembered cable."""

    lower: FloatArray
    upper: FloatArray
    box_density: float
    memory: FloatArray
    scales: FloatArray
    share: float
    side: float
    inset: float
    peak: float
    width: float
    height: float


class PriorArrays(NamedTuple):
    """What compiled loops need to know of a `Prior`.

    The kernels are those of floats of single precision, twice as many at a time. So that nothing is
    lost, their centres (4, M) are told from one of them, the origin, in units of their scales.
    """

    places: FloatArray
    origin: FloatArray
    centres: Image
    target: Image
    proposal: Image
    rates: FloatArray
    rate_sigmas: FloatArray
    scales: FloatArray
    peak: float
    degrees_of_freedom: float
    survived: float
    born: float
    log_width: float
    width_spread: float
    births: BirthArrays


def prior_arrays(prior: Prior) -> PriorArrays:
    """Lay out a prior for compiled loops."""
    kernels = prior.kernels
    scales = kernels.scales
    centres, target, proposal = _single(kernels.centres, scales, prior.target, prior.proposal)
    width = prior.usual_width
    return PriorArrays(
        places=kernels.centres,
        origin=kernels.centres[0],
        centres=centres,
        target=target,
        proposal=proposal,
        rates=prior.rates,
        rate_sigmas=prior.rate_sigmas,
        scales=scales,
        peak=peak_density(kernels.degrees_of_freedom, PLACES) / math.prod(scales.tolist()),
        degrees_of_freedom=kernels.degrees_of_freedom,
        survived=max(prior.existence.survived, MINIMUM_DENSITY),
        born=max(prior.existence.born, MINIMUM_DENSITY),
        log_width=width.log_width if width is not None else 0.0,
        width_spread=width.spread(prior.parameters) if width is not None else math.inf,
        births=_birth_arrays(prior),
    )


@compiled
def _single(
    places: FloatArray, scales: FloatArray, target: FloatArray, proposal: FloatArray
) -> tuple[Image, Image, Image]:
    """Return places (M, 4) from the first of them, over their scales, (4, M), and both weights."""
    centres = np.empty((PLACES, len(places)), np.float32)
    for row in range(len(places)):
        for column in range(PLACES):
            centres[column, row] = (places[row, column] - places[0, column]) / scales[column]
    return centres, target.astype(np.float32), proposal.astype(np.float32)


def _birth_arrays(prior: Prior) -> BirthArrays:
    births = prior.births
    lower, upper = births.box.lower, births.box.upper
    memory = births.memory
    scales = births.scales(memory) if memory is not None else np.ones(PLACES)
    return BirthArrays(
        lower=lower,
        upper=upper,
        box_density=1.0 / math.prod((upper - lower)[:PLACES].tolist()),
        memory=memory.places if memory is not None else np.zeros(PLACES),
        scales=scales,
        share=births.memory_share,
        side=memory.side if memory is not None else 0.0,
        inset=births.inset(memory) if memory is not None else 0.0,
        peak=BIRTH_PEAK / math.prod(scales.tolist()),
        width=float(births.image_size[0]),
        height=float(births.image_size[1]),
    )


class PriorDensities(NamedTuple):
    """Densities at N states, not logarithms, each of shape (N,); see the twin.

    `width_factors` are logarithms.
    """

    full: FloatArray
    survived: FloatArray
    survivors: FloatArray
    births: FloatArray
    width_factors: FloatArray


def empty_densities(count: int) -> PriorDensities:
    """Return room for the densities at some states."""
    return PriorDensities(*(np.empty(count) for _ in PriorDensities._fields))


@compiled
def weigh_by_prior(
    states: FloatArray, start: int, stop: int, prior: PriorArrays, densities: PriorDensities
) -> None:
    """Fill in the densities at the states from `start` to `stop`."""
    kernels = np.empty(len(prior.target), np.float32)
    for row in range(start, stop):
        _kernels_at(states[row], prior, kernels)
        _store(states[row], row, prior, kernels, densities)


@compiled
def choose_rates(
    states: FloatArray,
    start: int,
    stop: int,
    prior: PriorArrays,
    densities: PriorDensities,
    noise: FrameNoise,
) -> None:
    """Fill in the densities at states whose places were proposed, and draw their rates."""
    kernels = np.empty(len(prior.target), np.float32)
    for row in range(start, stop):
        _kernels_at(states[row], prior, kernels)
        _store(states[row], row, prior, kernels, densities)
        total = densities.survived[row] + prior.born * densities.births[row]
        ancestor = _ancestor_at(noise.uniform[row, 0] * total, prior, kernels)
        if ancestor < 0:
            _search_rates(states[row], noise.uniform[row], prior.births)
        else:
            add_rates(states[row], row, ancestor, prior, noise)


@compiled_inside
def add_rates(
    state: FloatArray, row: int, ancestor: int, prior: PriorArrays, noise: FrameNoise
) -> None:
    """Fill in the rates of the child of an ancestor."""
    stretch = noise.stretches[row, 1]
    for column in range(PLACES):
        spread = noise.normal[row, PLACES + column] * stretch * prior.rate_sigmas[column]
        state[PLACES + column] = prior.rates[ancestor, column] + spread


@compiled_inside
def _search_rates(state: FloatArray, uniform: FloatArray, births: BirthArrays) -> None:
    for column in range(PLACES, STATE_SIZE):
        state[column] = births.lower[column] + uniform[column] * (
            births.upper[column] - births.lower[column]
        )


@compiled
def place_births(
    states: FloatArray, start: int, stop: int, remembered: int, births: BirthArrays,
    noise: FrameNoise,
) -> None:  # fmt: skip
    """Draw births into the rows from `start` to `stop`, first those about the memory."""
    for row in range(start, stop):
        if row - start < remembered:
            _place_near(states[row], noise.about_memory[row - start], births)
        else:
            for column in range(STATE_SIZE):
                states[row, column] = births.lower[column] + noise.uniform[row, column] * (
                    births.upper[column] - births.lower[column]
                )


@compiled
def _place_near(state: FloatArray, noise: FloatArray, births: BirthArrays) -> None:
    angle = births.memory[1] + noise[1] * births.scales[1]
    state[0] = _middle_at(angle, births) + noise[0] * births.scales[0]
    state[1] = angle
    state[2] = births.memory[2] + noise[2] * births.scales[2]
    state[3] = births.memory[3] + noise[3] * births.scales[3]
    state[4:] = 0.0


@compiled_inside
def _middle_at(angle: float, births: BirthArrays) -> float:
    """Return the d about which a remembered cable is looked for, for an angle."""
    if births.side == 0.0:
        return float(births.memory[0])
    reach = abs(math.cos(angle)) * births.width + abs(math.sin(angle)) * births.height
    return births.side * (reach / 2 - max(births.inset, 0.0))


@compiled_inside
def _ancestor_at(position: float, prior: PriorArrays, kernels: Image) -> int:
    """Return which ancestor a position in the cumulated shares falls on; -1 for none: a birth."""
    cumulative = 0.0
    for ancestor in range(len(kernels)):
        cumulative += prior.survived * prior.peak * prior.target[ancestor] * kernels[ancestor]
        if cumulative > position:
            return ancestor
    return -1


@compiled_inside
def _store(
    state: FloatArray,
    row: int,
    prior: PriorArrays,
    kernels: Image,
    densities: PriorDensities,
) -> None:
    target, proposal = _mixtures(kernels, prior.target, prior.proposal)
    births = birth_density(state, prior.births)
    factor = log_width_factor(state[2], prior.log_width, prior.width_spread)
    densities.survived[row] = prior.survived * prior.peak * target
    densities.survivors[row] = prior.peak * proposal
    densities.births[row] = births
    densities.width_factors[row] = factor
    densities.full[row] = densities.survived[row] + prior.born * births * math.exp(factor)


@compiled_fast
def _kernels_at(state: FloatArray, prior: PriorArrays, kernels: Image) -> None:
    """Fill in the kernels (M,) at a place, over their peak."""
    first, second, third, fourth = (
        np.float32((state[0] - prior.origin[0]) / prior.scales[0]),
        np.float32((state[1] - prior.origin[1]) / prior.scales[1]),
        np.float32((state[2] - prior.origin[2]) / prior.scales[2]),
        np.float32((state[3] - prior.origin[3]) / prior.scales[3]),
    )
    ones, twos, threes, fours = (
        prior.centres[0], prior.centres[1], prior.centres[2], prior.centres[3],
    )  # fmt: skip
    if prior.degrees_of_freedom == 4.0:
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
            kernels[index] = tail(a * a + b * b + c * c + d * d, prior.degrees_of_freedom, 4)


@compiled_fast
def _mixtures(kernels: Image, target: Image, proposal: Image) -> tuple[float, float]:
    first, second = np.float32(0.0), np.float32(0.0)
    for index in range(len(kernels)):
        first += target[index] * kernels[index]
        second += proposal[index] * kernels[index]
    return float(first), float(second)


@compiled_inside
def log_width_factor(width: float, log_width: float, spread: float) -> float:
    """Return how well a width fits the usual one; 0 for a spread without end."""
    if math.isinf(spread):
        return 0.0
    deviation = (math.log(max(width, 1e-3)) - log_width) / spread
    return -0.5 * (WIDTH_TAIL + 1.0) * math.log1p(deviation * deviation / WIDTH_TAIL)


@compiled_inside
def birth_density(state: FloatArray, births: BirthArrays) -> float:
    """Return the density of births at the places of a state (8,)."""
    wrapped = wrapped_angle(state[1])
    sign = turn_sign(state[1], wrapped)
    inside = (
        births.lower[0] <= sign * state[0] <= births.upper[0]
        and births.lower[1] <= wrapped <= births.upper[1]
        and births.lower[2] <= state[2] <= births.upper[2]
        and births.lower[3] <= sign * state[3] <= births.upper[3]
    )
    anywhere = births.box_density if inside else 0.0
    if births.share == 0.0:
        return anywhere
    return (1.0 - births.share) * anywhere + births.share * _density_near(state, births)


@compiled_inside
def _density_near(state: FloatArray, births: BirthArrays) -> float:
    """Return the density about the memory, over all half turns that the angle may have made."""
    shifted = state[1] - births.memory[1]
    wrapped = wrapped_angle(shifted)
    turned = turn_sign(shifted, wrapped)
    # A half turn changes the signs of d and beta, and nothing else.
    middle = _middle_at(wrapped + births.memory[1], births)
    scales = births.scales
    width = (state[2] - births.memory[2]) / scales[2]
    as_it_is = _beside(turned * state[0], turned * state[3], middle, births)
    turned_round = _beside(-turned * state[0], -turned * state[3], middle, births)
    near = 0.0
    for turn in range(-MOST_TURNS, MOST_TURNS + 1):
        beside = as_it_is if turn % 2 == 0 else turned_round
        near += beside * _birth_tail((wrapped + turn * math.pi) / scales[1])
    return near * _birth_tail(width) * births.peak


@compiled_inside
def _beside(distance: float, skew: float, middle: float, births: BirthArrays) -> float:
    a = (distance - middle) / births.scales[0]
    d = (skew - births.memory[3]) / births.scales[3]
    return _birth_tail(a) * _birth_tail(d)


@compiled_inside
def _birth_tail(deviation: float) -> float:
    base = 1.0 + deviation * deviation / TAIL
    if TAIL == 4.0:
        return 1.0 / (base * base * math.sqrt(base))
    return math.pow(base, -0.5 * (TAIL + 1.0))
