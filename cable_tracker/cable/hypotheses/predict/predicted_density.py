"""The density of the cable before a frame is looked at: survivors, border switches, births."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.predict.births import (
    BirthDensity,
    birth_density,
    drawn_birth_density,
)
from cable_tracker.cable.hypotheses.predict.border_switch import BorderSwitch, switch_density
from cable_tracker.cable.hypotheses.predict.frame_noise import FrameNoise
from cable_tracker.cable.hypotheses.predict.remembered_cable import width_penalty
from cable_tracker.cable.model.initial_state import between
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE, WIDTH
from cable_tracker.compilation import compiled_inside, compiled_loop
from cable_tracker.particle_filter.student_t import (
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
    rates : FloatArray
        Drifted rates of the ancestors, shape (M, 4).
    rate_gains, rate_scales : FloatArray
        Diffusion of the rates given that of the pose, shape (4,), see `Diffusion`.
    mass_survived, mass_born : float
        Probability mass of the survivors' part of f, P(survived), and of the births' part, P(born).
    log_width, width_spread : float
        The width prior; its spread is infinite where there is none.
    births : BirthDensity
        The density b.
    mass_switched : float
        Probability mass of the border-switch density.
    border_switch : BorderSwitch
        The border-switch density S.
    """

    kernels: KernelMixture
    rates: FloatArray
    rate_gains: FloatArray
    rate_scales: FloatArray
    mass_survived: float
    mass_born: float
    log_width: float
    width_spread: float
    births: BirthDensity
    mass_switched: float
    border_switch: BorderSwitch


class DensityValues(NamedTuple):
    """Values of densities at N states, each of shape (N,); not logarithms but for the penalties.

    Attributes
    ----------
    prior : FloatArray
        The density f before the frame, all parts with their masses.
    prior_survival : FloatArray
        The survivors' part of f, with its mass.
    survivor_proposal : FloatArray
        Density that survivors are drawn from: the kernels of f, equally weighted; it integrates to
        one.
    birth, border_switch : FloatArray
        The birth density b and the border-switch density S, without their masses.
    birth_proposal : FloatArray
        Density that births are drawn from: b without the map.
    width_penalties : FloatArray
        Log-density of the width over its peak, by the width prior, at most 0 [nats].
    """

    prior: FloatArray
    prior_survival: FloatArray
    survivor_proposal: FloatArray
    birth: FloatArray
    border_switch: FloatArray
    birth_proposal: FloatArray
    width_penalties: FloatArray


def empty_densities(count: int) -> DensityValues:
    """Return empty arrays for the densities at some states."""
    return DensityValues(*(np.empty(count) for _ in DensityValues._fields))


@compiled_loop
def fill_densities(
    states: FloatArray, count: int, predicted: PredictedDensity, densities: DensityValues
) -> None:
    """Fill in the densities at the first states."""
    for row in range(count):
        _fill_densities_of(states[row], row, predicted, densities)


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
        _fill_densities_of(state, row, predicted, densities)
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


@compiled_inside
def _fill_densities_of(
    state: FloatArray, row: int, predicted: PredictedDensity, densities: DensityValues
) -> None:
    """Fill in the densities at one state; the values of the kernels there are left in them."""
    kernels = predicted.kernels
    evaluate_kernels(kernels, state)
    target, proposal = weighted_sums(kernels)
    drawn = drawn_birth_density(state, predicted.births)
    births = birth_density(state, drawn, predicted.births)
    penalty = width_penalty(state[WIDTH], predicted.log_width, predicted.width_spread)
    switches = switch_density(state, predicted.border_switch)
    densities.prior_survival[row] = predicted.mass_survived * kernels.peak * target
    densities.survivor_proposal[row] = kernels.peak * proposal
    densities.birth[row], densities.birth_proposal[row] = births, drawn
    densities.border_switch[row] = switches
    densities.width_penalties[row] = penalty
    # Births get the width penalty twice, here in the prior and again in `fill_log_likelihoods`.
    # With it once, strips beside a tracked cable took over more often (S4, S6).
    new = predicted.mass_born * births * math.exp(penalty) + predicted.mass_switched * switches
    densities.prior[row] = densities.prior_survival[row] + new
