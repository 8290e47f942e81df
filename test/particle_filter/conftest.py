from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from cable_tracker.particle_filter.filter import ParticleFilter
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import systematic_resampling
from cable_tracker.particle_filter.student_t import standard_student_t


class RandomWalk:
    """Diffusion of the given variance per second."""

    def __init__(self, variance: float) -> None:
        self._variance = variance

    def propagate(self, states, dt, rng):
        return states + rng.standard_normal(states.shape) * np.sqrt(self._variance * dt)


class NoisyPosition:
    """Measures the first component with Gaussian noise."""

    def __init__(self, variance: float) -> None:
        self._variance = variance

    def log_likelihoods(self, states, observation):
        return -((states[:, 0] - observation) ** 2) / (2 * self._variance)


class GivenLikelihoods:
    """An observation that is the array of log-likelihoods itself."""

    def log_likelihoods(self, states, observation):
        assert len(states) == len(observation)
        return observation


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20081)


@pytest.fixture
def draw_standard(rng) -> Callable[..., np.ndarray]:
    """Draw Student-t points of location zero and unit scale."""

    return partial(standard_student_t, rng)


@pytest.fixture
def make_filter() -> Callable[..., ParticleFilter]:
    """Make a filter of equally weighted particles that are told their likelihoods."""

    def make(states, *, variance=0.0, threshold=0.5, seed=0, observation=None) -> ParticleFilter:
        return ParticleFilter(
            Particles.equally_weighted(np.asarray(states, dtype=np.float64)),
            movement=RandomWalk(variance),
            observation=observation or GivenLikelihoods(),
            resampling=systematic_resampling,
            resampling_threshold=threshold,
            rng=np.random.default_rng(seed),
        )

    return make


@pytest.fixture
def noisy_position() -> type[NoisyPosition]:
    return NoisyPosition
