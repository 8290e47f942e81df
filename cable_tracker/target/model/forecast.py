"""The belief before a frame is looked at, and the mixtures that particles are drawn from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.particle_filter.existence import PredictedExistence
from cable_tracker.particle_filter.kernel_mixture import KernelMixture, log_kernels
from cable_tracker.particle_filter.resampling import systematic_resampling
from cable_tracker.particle_filter.student_t import standard_student_t
from cable_tracker.target.model.births import Births
from cable_tracker.target.model.state import PLACES

NEVER = 1e-300
"""Stands for a probability of zero where its logarithm is needed."""


def log_mix(logs: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the log of rows of log-densities (N, M), mixed by weights (M,), shape (N,)."""
    peaks = logs.max(axis=1)
    with np.errstate(divide="ignore"):
        mixed: FloatArray = peaks + np.log(np.exp(logs - peaks[:, None]) @ weights)
    return mixed


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """One part of the mixture that particles are drawn from.

    Attributes
    ----------
    kernels : KernelMixture
        Of places.
    weights : FloatArray
        Of the kernels, summing to one.
    share : float
        Of the particles that come from this part.
    """

    kernels: KernelMixture
    weights: FloatArray
    share: float

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw places, shape (count, 4)."""
        if count == 0:
            return np.empty((0, PLACES))
        chosen = systematic_resampling(self.weights, count, rng)
        noise = standard_student_t(rng, count, PLACES, self.kernels.degrees_of_freedom)
        places: FloatArray = self.kernels.places[chosen] + noise * self.kernels.scales
        return places

    def log_density(self, places: FloatArray) -> FloatArray:
        """Return the log of its share of the whole mixture's density at places (N, 4)."""
        return math.log(self.share) + log_mix(log_kernels(places, self.kernels), self.weights)


@dataclass(frozen=True, slots=True, eq=False)
class Forecast:
    """The predicted belief: what has survived, what has jumped, and what has come into view.

    Attributes
    ----------
    kernels : KernelMixture
        About the moved ancestors; shape (M, 4) of centres.
    rates : FloatArray
        Of the ancestors, shape (M, 2).
    alive : FloatArray
        Shares of the ancestors by their survival, shape (M,), summing to one.
    births : Births
        Where what jumps or comes into view is.
    predicted : PredictedExistence
        Probabilities of both.
    jump_share : float
        Of the survivors.
    """

    kernels: KernelMixture
    rates: FloatArray
    alive: FloatArray
    births: Births
    predicted: PredictedExistence
    jump_share: float

    @property
    def even(self) -> FloatArray:
        """Equal weights of the ancestors, shape (M,)."""
        return np.full(len(self.alive), 1.0 / len(self.alive))

    def log_density(self, states: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return log-densities at poses (N, 6).

        Returns
        -------
        tuple of FloatArray
            Of the belief, whose mass is the probability that the target is in view, shape (N,); of
            the births, shape (N,); of the kernels, shape (N, M).
        """
        kernel_logs = log_kernels(states, self.kernels)
        birth = self.births.log_density(states)
        following = (1.0 - self.jump_share) * self.predicted.survived
        elsewhere = self.jump_share * self.predicted.survived + self.predicted.born
        belief: FloatArray = np.logaddexp(
            math.log(max(following, NEVER)) + log_mix(kernel_logs, self.alive),
            math.log(max(elsewhere, NEVER)) + birth,
        )
        return belief, birth, kernel_logs
