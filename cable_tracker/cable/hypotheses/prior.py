"""The density of the cable before a frame is looked at: survivors of the last frame, and births."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.hypotheses.border_jump import BorderJump, jump_density
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise
from cable_tracker.cable.hypotheses.survival_and_birth import BirthDensity, birth_density
from cable_tracker.cable.hypotheses.width_prior import width_penalty
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.compilation import compiled_inside, compiled_part
from cable_tracker.particle_filter.kernel_mixture import (
    KernelMixture,
    choose_kernel,
    kernels_at,
    weighted_sums,
)

MINIMUM_DENSITY = 1e-12
"""Stands for a probability of zero where its logarithm is taken."""


class Prior(NamedTuple):
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


class PriorDensities(NamedTuple):
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


def empty_densities(count: int) -> PriorDensities:
    """Return room for the densities at some states."""
    return PriorDensities(*(np.empty(count) for _ in PriorDensities._fields))


@compiled_part
def weigh_by_prior(
    states: FloatArray, start: int, stop: int, prior: Prior, densities: PriorDensities
) -> None:
    """Fill in the densities at the states from `start` to `stop`."""
    kernels = np.empty(len(prior.rates), np.float32)
    for row in range(start, stop):
        kernels_at(states[row], prior.kernels, kernels)
        _store(states[row], row, prior, kernels, densities)


@compiled_part
def choose_rates(
    states: FloatArray,
    start: int,
    stop: int,
    prior: Prior,
    densities: PriorDensities,
    noise: FrameNoise,
) -> None:
    """Fill in the densities at states whose poses were proposed, and draw their rates.

    An ancestor is drawn by how likely it would have moved there; a cable that was more likely born
    there has the rates of the search.
    """
    kernels = np.empty(len(prior.rates), np.float32)
    for row in range(start, stop):
        kernels_at(states[row], prior.kernels, kernels)
        _store(states[row], row, prior, kernels, densities)
        new = prior.born * densities.births[row] + prior.jumped * densities.jumps[row]
        total = densities.survived[row] + new
        position = noise.uniform[row, 0] * total
        ancestor = choose_kernel(kernels, prior.kernels, prior.survived, position)
        if ancestor < 0:
            _search_rates(states[row], noise.uniform[row], prior.births)
        else:
            add_rates(states[row], row, ancestor, prior, noise)


@compiled_inside
def add_rates(state: FloatArray, row: int, ancestor: int, prior: Prior, noise: FrameNoise) -> None:
    """Fill in the rates of the child of an ancestor."""
    stretch = noise.stretches[row, 1]
    for column in range(POSE_SIZE):
        spread = noise.normal[row, POSE_SIZE + column] * stretch * prior.rate_sigmas[column]
        state[POSE_SIZE + column] = prior.rates[ancestor, column] + spread


@compiled_inside
def _search_rates(state: FloatArray, uniform: FloatArray, births: BirthDensity) -> None:
    for column in range(POSE_SIZE, STATE_SIZE):
        state[column] = births.lower[column] + uniform[column] * (
            births.upper[column] - births.lower[column]
        )


@compiled_inside
def _store(
    state: FloatArray,
    row: int,
    prior: Prior,
    kernels: Image,
    densities: PriorDensities,
) -> None:
    target, proposal = weighted_sums(kernels, prior.kernels)
    peak = prior.kernels.peak
    births = birth_density(state, prior.births)
    penalty = width_penalty(state[2], prior.log_width, prior.width_spread)
    densities.survived[row] = prior.survived * peak * target
    densities.survivors[row] = peak * proposal
    jumps = jump_density(state, prior.jump)
    densities.births[row] = births
    densities.jumps[row] = jumps
    densities.width_penalties[row] = penalty
    # Where a border was wrong, the width was wrong too, and says nothing.
    new = prior.born * births * math.exp(penalty) + prior.jumped * jumps
    densities.full[row] = densities.survived[row] + new
