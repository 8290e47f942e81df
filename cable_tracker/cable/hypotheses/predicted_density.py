"""The density of the cable before a frame is looked at: survivors, border switches, births."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.births import (
    BirthDensity,
    BorderSwitch,
    birth_density,
    drawn_birth_density,
    switch_density,
)
from cable_tracker.cable.model.state import WIDTH
from cable_tracker.compilation import compiled_inside, compiled_loop
from cable_tracker.particle_filter.student_t import (
    KernelMixture,
    evaluate_kernels,
    relative_log_density,
    weighted_sums,
)

LEAST_PROBABILITY = 1e-12
"""Stands for a probability or a number of zero where something is divided by it."""

WIDTH_TAIL = 4.0
"""Degrees of freedom of the Student-t about the mean width."""

NARROWEST = 1e-3
"""Lower bound of a width whose logarithm is taken [px]."""


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
        fill_densities_of(states[row], row, predicted, densities)


@compiled_inside
def fill_densities_of(
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


@compiled_inside
def width_penalty(width: float, log_width: float, spread: float) -> float:
    """Return the log-density of a width [px] over its peak, at most 0; 0 for infinite spread."""
    if math.isinf(spread):
        return 0.0
    deviation = (math.log(max(width, NARROWEST)) - log_width) / spread
    return relative_log_density(deviation * deviation, WIDTH_TAIL, 1)
