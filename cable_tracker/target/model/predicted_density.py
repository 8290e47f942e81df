"""The predicted density of the poses in a frame, and the mixtures that particles are drawn from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.existence import PredictedExistence
from cable_tracker.particle_filter.particles import systematic_resampling
from cable_tracker.particle_filter.student_t import (
    KernelMixture,
    relative_density,
    standard_student_t,
)
from cable_tracker.target.model.births import Births
from cable_tracker.target.model.state import POSE_SIZE

NEVER = 1e-300
"""Stands for a probability of zero where its logarithm is needed."""


@compiled
def relative_kernels(
    points: FloatArray, centres: FloatArray, scales: FloatArray, tail: float
) -> FloatArray:
    """Return Student-t kernels about centres at points, over their peak, shape (N, M).

    Parameters
    ----------
    points, centres : FloatArray
        Shapes (N, 4 or more) and (M, 4).
    scales : FloatArray
        Scales of the kernels along the four axes, shape (4,).
    tail : float
        Degrees of freedom.
    """
    values = np.empty((len(points), len(centres)))
    for row in range(len(points)):
        for column in range(len(centres)):
            squared = 0.0
            for axis in range(POSE_SIZE):
                offset = (points[row, axis] - centres[column, axis]) / scales[axis]
                squared += offset * offset
            values[row, column] = relative_density(squared, tail, POSE_SIZE)
    return values


@compiled
def choose_columns(values: FloatArray, shares: FloatArray) -> NDArray[np.int64]:
    """Draw a column of each row (N, M) by its values, from uniform numbers (N,), shape (N,)."""
    chosen = np.empty(len(values), np.int64)
    for row in range(len(values)):
        total = 0.0
        for column in range(values.shape[1]):
            total += values[row, column]
        rest = shares[row] * total
        chosen[row] = values.shape[1] - 1
        for column in range(values.shape[1]):
            rest -= values[row, column]
            if rest < 0.0:
                chosen[row] = column
                break
    return chosen


def log_mix(values: FloatArray, weights: FloatArray, mixture: KernelMixture) -> FloatArray:
    """Return the log-density of kernels (N, M) of a mixture, by weights (M,), shape (N,)."""
    with np.errstate(divide="ignore"):
        mixed: FloatArray = math.log(mixture.peak) + np.log(values @ weights)
    return mixed


def kernels_of(states: FloatArray, mixture: KernelMixture) -> FloatArray:
    """Return the kernels of a mixture at poses (N, 4 or more), over their peak, shape (N, M)."""
    tail = float(mixture.degrees_of_freedom)
    return relative_kernels(states, mixture.places, mixture.scales, tail)


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """One part of the mixture that particles are drawn from.

    Attributes
    ----------
    kernels : KernelMixture
        Kernels over poses.
    weights : FloatArray
        Weights of the kernels, summing to one.
    share : float
        Share of the particles that come from this part.
    """

    kernels: KernelMixture
    weights: FloatArray
    share: float

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw poses, shape (count, 4)."""
        if count == 0:
            return np.empty((0, POSE_SIZE))
        chosen = systematic_resampling(self.weights, count, rng)
        noise = standard_student_t(rng, count, POSE_SIZE, self.kernels.degrees_of_freedom)
        poses: FloatArray = self.kernels.places[chosen] + noise * self.kernels.scales
        return poses

    def log_density(self, poses: FloatArray) -> FloatArray:
        """Return the log of its share of the whole mixture's density at poses (N, 4)."""
        kernels = kernels_of(poses, self.kernels)
        return math.log(self.share) + log_mix(kernels, self.weights, self.kernels)


@dataclass(frozen=True, slots=True, eq=False)
class PredictedDensity:
    """The predicted density: of targets that survived, jumped, or came into view.

    Attributes
    ----------
    kernels : KernelMixture
        About the moved ancestors; shape (M, 4) of centres.
    rates : FloatArray
        Rates of the ancestors, shape (M, 2).
    alive : FloatArray
        Shares of the ancestors by their survival, shape (M,), summing to one.
    births : Births
        Density of the poses of targets that jump or come into view.
    memory_share : float
        Share of the births about the last place.
    existence : PredictedExistence
        Probabilities that the target has survived, and that it has come into view.
    jump_share : float
        Share of the survivors that jump.
    """

    kernels: KernelMixture
    rates: FloatArray
    alive: FloatArray
    births: Births
    memory_share: float
    existence: PredictedExistence
    jump_share: float

    @property
    def even(self) -> FloatArray:
        """Equal weights of the ancestors, shape (M,)."""
        return np.full(len(self.alive), 1.0 / len(self.alive))

    def draw_births(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw poses of a target that appears, shape (count, 4)."""
        return self.births.draw(count, self.memory_share, rng)[:, :POSE_SIZE]

    def log_density(self, states: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return log-densities at poses (N, 6).

        Returns
        -------
        tuple of FloatArray
            Log-density of the belief, whose mass is the probability that the target is in view,
            shape (N,); that of the births, shape (N,); kernels over their peak, shape (N, M).
        """
        kernels = kernels_of(states, self.kernels)
        birth = self.births.log_density(states, self.memory_share)
        following = (1.0 - self.jump_share) * self.existence.survived
        elsewhere = self.jump_share * self.existence.survived + self.existence.born
        belief: FloatArray = np.logaddexp(
            math.log(max(following, NEVER)) + log_mix(kernels, self.alive, self.kernels),
            math.log(max(elsewhere, NEVER)) + birth,
        )
        return belief, birth, kernels
