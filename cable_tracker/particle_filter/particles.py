"""A weighted set of particles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.particle_filter.weights import normalise_log_weights, uniform_log_weights


@dataclass(frozen=True, slots=True, eq=False)
class Particles:
    """N weighted hypotheses about a state of k components. Never changed in place.

    Attributes
    ----------
    states : FloatArray
        States, shape (N, k), N >= 1.
    log_weights : FloatArray
        Log-weights, shape (N,), normalised: the exponentials sum to one.

    Raises
    ------
    ValueError
        The shapes do not belong together, or there is no particle.
    """

    states: FloatArray
    log_weights: FloatArray

    def __post_init__(self) -> None:
        if self.states.ndim != 2 or len(self.states) == 0:
            raise ValueError(f"states must have shape (N >= 1, k), not {self.states.shape}")
        if self.log_weights.shape != (len(self.states),):
            raise ValueError(
                f"log_weights must have shape ({len(self.states)},), not {self.log_weights.shape}"
            )

    @classmethod
    def equally_weighted(cls, states: FloatArray) -> Particles:
        """Give every state the same weight."""
        return cls(states, uniform_log_weights(len(states)))

    @property
    def count(self) -> int:
        """Number of particles, N."""
        return len(self.states)

    @property
    def weights(self) -> FloatArray:
        """Weights on the linear scale, shape (N,), summing to one."""
        weights: FloatArray = np.exp(self.log_weights)
        return weights

    def moved_to(self, states: FloatArray) -> Particles:
        """Return particles with these states and the same weights."""
        return Particles(states, self.log_weights)

    def reweighted(self, log_likelihoods: FloatArray) -> Particles:
        """Multiply the weights by likelihoods, shape (N,), and normalise them.

        Where no particle has a positive weight left, the weights stay those of before: an
        observation that excludes everything is no information.
        """
        if log_likelihoods.shape != self.log_weights.shape:
            raise ValueError(
                f"log_likelihoods must have shape {self.log_weights.shape},"
                f" not {log_likelihoods.shape}"
            )
        # A weight of zero times an infinite likelihood is NaN here, and zero after normalisation.
        with np.errstate(invalid="ignore", over="ignore"):
            products = self.log_weights + log_likelihoods
        posterior = normalise_log_weights(products)
        if posterior.degenerate:
            return self
        return Particles(self.states, posterior.log_weights)

    def selected(self, indices: IndexArray) -> Particles:
        """Return the particles at `indices`, equally weighted."""
        return Particles.equally_weighted(self.states[indices])
