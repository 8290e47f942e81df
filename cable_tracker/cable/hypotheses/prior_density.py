"""The density of the cable before a frame is looked at: survivors of the last frame, and births."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.leaving import BirthDensity
from cable_tracker.cable.hypotheses.usual_width import UsualWidth
from cable_tracker.cable.model.state import PLACES
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import PredictedExistence
from cable_tracker.particle_filter.kernel_mixture import KernelMixture

MINIMUM_DENSITY = 1e-12
"""Stands for a probability of zero where its logarithm is taken."""


@dataclass(frozen=True, slots=True, eq=False)
class PriorDensities:
    """Log-densities at N states.

    Attributes
    ----------
    full : FloatArray
        Of f, whose mass is the probability that there is a cable.
    survived : FloatArray
        Of the part of f that survived.
    survivors : FloatArray
        Of the mixture that survivors are drawn from.
    births : FloatArray
        Of the density b.
    """

    full: FloatArray
    survived: FloatArray
    survivors: FloatArray
    births: FloatArray

    def log_share_of_survivors(self) -> FloatArray:
        """Return the logarithm of the share of f that survived, shape (N,)."""
        with np.errstate(invalid="ignore"):
            shares = self.survived - self.full
        # Where f vanishes nothing survived either.
        return np.where(np.isfinite(self.full), shares, -np.inf)

    def joined(self, other: PriorDensities) -> PriorDensities:
        """Return those of these states and then of others."""
        return PriorDensities(
            np.concatenate((self.full, other.full)),
            np.concatenate((self.survived, other.survived)),
            np.concatenate((self.survivors, other.survivors)),
            np.concatenate((self.births, other.births)),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """The density f of the cable before the frame is looked at, in one chart.

    Attributes
    ----------
    kernels : KernelMixture
        About the drifted ancestors, for d, alpha, w, beta.
    target : FloatArray
        Weights of the ancestors in f, shape (M,), summing to one.
    proposal : FloatArray
        Weights by which they are drawn from: flatter, shape (M,), summing to one.
    rates : FloatArray
        Drifted rates of the ancestors, shape (M, 4).
    rate_sigmas : FloatArray
        Scale of the diffusion of the rates, shape (4,).
    births : BirthDensity
        The density b.
    existence : PredictedExistence
        The masses of the two parts.
    reference_angle : float
        Middle of the chart [rad].
    usual_width : UsualWidth or None
        How wide the cable was before; a new one of another width is less likely.
    parameters : TrackerParameters
        For how much less.
    leader_shift : FloatArray
        How far the leading cluster drifts in d, alpha, w, beta, shape (4,).
    """

    kernels: KernelMixture
    target: FloatArray
    proposal: FloatArray
    rates: FloatArray
    rate_sigmas: FloatArray
    births: BirthDensity
    existence: PredictedExistence
    reference_angle: float
    usual_width: UsualWidth | None
    parameters: TrackerParameters
    leader_shift: FloatArray

    def log_densities(self, states: FloatArray) -> PriorDensities:
        """Return the densities at states (N, 8) of the chart."""
        target, proposal = self.kernels.log_densities(
            states[:, :PLACES], (self.target, self.proposal)
        )
        births = self.births.log_density(states)
        survived = math.log(max(self.existence.survived, MINIMUM_DENSITY)) + target
        born = math.log(max(self.existence.born, MINIMUM_DENSITY)) + births
        born = born + self.log_width_factors(states)
        full = np.logaddexp(survived, born)
        return PriorDensities(full, survived, proposal, births)

    def log_width_factors(self, states: FloatArray) -> FloatArray:
        """Return how well the widths of states (N, 8) fit the usual one, shape (N,); at most 0."""
        if self.usual_width is None:
            return np.zeros(len(states))
        return self.usual_width.log_factors(states, self.parameters)

    def rates_about(self, ancestors: IndexArray, noise: FloatArray) -> FloatArray:
        """Return the rates of the children of some ancestors for noise of unit scale, (n, 4)."""
        return self.rates[ancestors] + noise * self.rate_sigmas

    def rates_from(self, states: FloatArray, uniform: FloatArray, noise: FloatArray) -> FloatArray:
        """Return the rates of states whose places were proposed, shape (N, 4).

        An ancestor is drawn by how likely it would have moved there; a cable that was more likely
        born there has the rates of the search.

        Parameters
        ----------
        states : FloatArray
            Shape (N, 8).
        uniform : FloatArray
            Random numbers from 0 to 1, shape (N, 8); see `FrameNoise`.
        noise : FloatArray
            Of unit scale, shape (N, 4).
        """
        born = math.log(max(self.existence.born, MINIMUM_DENSITY)) + self.births.log_density(states)
        with np.errstate(divide="ignore"):
            moved = (
                math.log(max(self.existence.survived, MINIMUM_DENSITY))
                + np.log(self.target)
                + self.kernels.log_kernels(states[:, :PLACES])
            )
        log_shares = np.column_stack((moved, born))
        shares = np.exp(log_shares - log_shares.max(axis=1, keepdims=True))
        cumulative = np.cumsum(shares, axis=1)
        positions = uniform[:, :1] * cumulative[:, -1:]
        chosen = (cumulative <= positions).sum(axis=1)
        is_born = chosen >= len(self.target)
        rates = self.rates_about(np.where(is_born, 0, chosen), noise)
        searched = self.births.box.placed(uniform)[:, PLACES:]
        return np.where(is_born[:, None], searched, rates)
