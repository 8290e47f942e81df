"""The cycle of a particle filter with conditional resampling."""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np

from cable_tracker.particle_filter.models import MovementModel, ObservationModel
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import ResamplingScheme
from cable_tracker.particle_filter.weights import effective_sample_size

Observation = TypeVar("Observation")


class ParticleFilter(Generic[Observation]):
    """Sequential importance resampling (thesis, algorithm of section 3.3).

    Parameters
    ----------
    particles : Particles
        The prior.
    movement, observation : MovementModel, ObservationModel
        The world.
    resampling : ResamplingScheme
        One of `resampling.RESAMPLING_SCHEMES`.
    resampling_threshold : float
        Resample when N_eff falls below this share of N; 0 never, above 1 always.
    rng : numpy.random.Generator
        The only source of randomness.

    Attributes
    ----------
    particles : Particles
        The present belief.
    """

    def __init__(
        self,
        particles: Particles,
        *,
        movement: MovementModel,
        observation: ObservationModel[Observation],
        resampling: ResamplingScheme,
        resampling_threshold: float,
        rng: np.random.Generator,
    ) -> None:
        self.particles = particles
        self._movement = movement
        self._observation = observation
        self._resampling = resampling
        self._resampling_threshold = resampling_threshold
        self._rng = rng

    def resample_if_degenerate(self) -> bool:
        """Resample when the effective sample size has fallen below the threshold.

        Otherwise the particles keep their weights, so that the next likelihood multiplies them.
        """
        size = effective_sample_size(self.particles.log_weights)
        if size >= self._resampling_threshold * self.particles.count:
            return False
        self.resample(self.particles.count)
        return True

    def resample(self, count: int) -> None:
        """Replace the particles by `count` equally weighted ones drawn from them."""
        indices = self._resampling(self.particles.weights, count, self._rng)
        self.particles = self.particles.selected(indices)

    def predict(self, dt: float) -> None:
        """Move every particle `dt` seconds ahead."""
        states = self._movement.propagate(self.particles.states, dt, self._rng)
        self.particles = self.particles.moved_to(states)

    def update(self, observation: Observation) -> float:
        """Weigh every particle by the observation; return the log-evidence."""
        log_likelihoods = self._observation.log_likelihoods(self.particles.states, observation)
        self.particles, log_evidence = self.particles.reweighted(log_likelihoods)
        return log_evidence

    def step(self, dt: float, observation: Observation) -> float:
        """Resample if needed, predict, update; return the log-evidence."""
        self.resample_if_degenerate()
        self.predict(dt)
        return self.update(observation)
