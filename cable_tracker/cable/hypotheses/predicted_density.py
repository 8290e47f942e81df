"""The density of the cable before a frame is looked at: survivors of the last frame, and births."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.births import BirthDensity, birth_density
from cable_tracker.cable.hypotheses.border_jump import BorderJump, jump_density
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise
from cable_tracker.cable.hypotheses.width_prior import width_penalty
from cable_tracker.cable.model.initial_state import between
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE, WIDTH
from cable_tracker.compilation import compiled_inside, compiled_loop
from cable_tracker.particle_filter.kernel_mixture import (
    KernelMixture,
    choose_kernel,
    evaluate_kernels,
    weighted_sums,
)

LEAST_PROBABILITY = 1e-12
"""Stands for a probability or a number of zero where something is divided by it."""


class PredictedDensity(NamedTuple):
    """The density f of the cable before the frame is looked at, in one chart.

    Attributes
    ----------
    kernels : KernelMixture
        About the drifted ancestors, for d, alpha, w, beta. Their weights are those in f; survivors
        are drawn from each alike.
    rates, rate_sigmas : FloatArray
        Drifted rates of the ancestors, shape (M, 4), and scale of their diffusion, shape (4,).
    survived, born : float
        Masses of the two parts of f.
    log_width, width_spread : float
        The width prior; its spread is infinite where there is none.
    births : BirthDensity
        The density b.
    jumped : float
        Mass of the part of f in which one border was another's.
    jump : BorderJump
        The density of that part.
    """

    kernels: KernelMixture
    rates: FloatArray
    rate_sigmas: FloatArray
    survived: float
    born: float
    log_width: float
    width_spread: float
    births: BirthDensity
    jumped: float
    jump: BorderJump


class PredictedDensities(NamedTuple):
    """Densities at N states, not logarithms, each of shape (N,).

    Attributes
    ----------
    full, survived : FloatArray
        Of f, and of the part of f that survived.
    survivors, births, jumps : FloatArray
        Of the mixture that survivors are drawn from, of b, and of jumps.
    width_penalties : FloatArray
        Logarithms of how well the widths fit.
    """

    full: FloatArray
    survived: FloatArray
    survivors: FloatArray
    births: FloatArray
    jumps: FloatArray
    width_penalties: FloatArray


def empty_densities(count: int) -> PredictedDensities:
    """Return empty arrays for the densities at some states."""
    return PredictedDensities(*(np.empty(count) for _ in PredictedDensities._fields))


@compiled_loop
def fill_densities(
    states: FloatArray,
    start: int,
    stop: int,
    predicted: PredictedDensity,
    densities: PredictedDensities,
) -> None:
    """Fill in the densities at the states from `start` to `stop`."""
    for row in range(start, stop):
        _fill_densities_of(states[row], row, predicted, densities)


@compiled_loop
def choose_rates(
    states: FloatArray,
    start: int,
    stop: int,
    predicted: PredictedDensity,
    densities: PredictedDensities,
    noise: FrameNoise,
) -> None:
    """Fill in the densities at states whose poses were proposed, and draw their rates.

    An ancestor is drawn by how likely it would have moved there; a cable that was more likely born
    there has the rates of the search.
    """
    births = predicted.births
    for row in range(start, stop):
        state = states[row]
        _fill_densities_of(state, row, predicted, densities)
        new = predicted.born * densities.births[row] + predicted.jumped * densities.jumps[row]
        total = densities.survived[row] + new
        position = noise.uniform[row, 0] * total
        ancestor = choose_kernel(predicted.kernels, predicted.survived, position)
        if ancestor >= 0:
            add_rates(state, row, ancestor, predicted, noise)
            continue
        for column in range(POSE_SIZE, STATE_SIZE):
            state[column] = between(
                births.lower[column], births.upper[column], noise.uniform[row, column]
            )


@compiled_inside
def add_rates(
    state: FloatArray, row: int, ancestor: int, predicted: PredictedDensity, noise: FrameNoise
) -> None:
    """Fill in the rates of the child of an ancestor."""
    stretch = noise.stretches[row, 1]
    for column in range(POSE_SIZE):
        spread = noise.normal[row, POSE_SIZE + column] * stretch * predicted.rate_sigmas[column]
        state[POSE_SIZE + column] = predicted.rates[ancestor, column] + spread


@compiled_loop
def _fill_densities_of(
    state: FloatArray, row: int, predicted: PredictedDensity, densities: PredictedDensities
) -> None:
    """Fill in the densities at one state; the values of the kernels there are left in them."""
    kernels = predicted.kernels
    evaluate_kernels(kernels, state)
    target, proposal = weighted_sums(kernels)
    births = birth_density(state, predicted.births)
    penalty = width_penalty(state[WIDTH], predicted.log_width, predicted.width_spread)
    jumps = jump_density(state, predicted.jump)
    densities.survived[row] = predicted.survived * kernels.peak * target
    densities.survivors[row] = kernels.peak * proposal
    densities.births[row] = births
    densities.jumps[row] = jumps
    densities.width_penalties[row] = penalty
    # Where a border was wrong, the width was wrong too, and says nothing.
    new = predicted.born * births * math.exp(penalty) + predicted.jumped * jumps
    densities.full[row] = densities.survived[row] + new
