"""What the filter needs to know about the world: how states move, and what is likely to be seen."""

from __future__ import annotations

from typing import Protocol, TypeVar

import numpy as np

from cable_tracker.arrays import FloatArray

Observation_contra = TypeVar("Observation_contra", contravariant=True)


class MovementModel(Protocol):
    """p(x_t | x_{t-1}), as something one can draw from."""

    def propagate(self, states: FloatArray, dt: float, rng: np.random.Generator) -> FloatArray:
        """Draw the states after `dt` seconds, shape (N, k), given the states before."""
        ...


class ObservationModel(Protocol[Observation_contra]):
    """p(y_t | x_t), up to a factor common to all states."""

    def log_likelihoods(self, states: FloatArray, observation: Observation_contra) -> FloatArray:
        """Return the log-likelihood of each state, shape (N,); -inf where it is impossible."""
        ...
