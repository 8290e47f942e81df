"""Which particles go on to the next frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.clusters import SMALLEST_MASS, Clusters
from cable_tracker.cable.model.geometry import image_reach, state_in_chart
from cable_tracker.cable.model.state import ANGLE, DISTANCE
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import ResamplingScheme
from cable_tracker.tracking.survival import SurvivalRates, survival_probability

SMALLEST_CLUSTER_SHARE = 0.06
"""Minimum share of the ancestors that are drawn from each cluster."""

LEAST_SURVIVING = 1e-300
"""Positive floor of an ancestor's weight, so that the weights can be normalised."""


class Ancestors(NamedTuple):
    """Particles that go on to the next frame.

    Attributes
    ----------
    states : FloatArray
        Particles of the frame before, shape (M, 8).
    weights : FloatArray
        Their weights in the predicted density, shape (M,), summing to one: a light cluster has more
        ancestors than its mass, with smaller weights.
    """

    states: FloatArray
    weights: FloatArray


def draw_ancestors(
    particles: Particles,
    clusters: Clusters,
    count: int,
    resample: ResamplingScheme,
    rng: np.random.Generator,
) -> Ancestors:
    """Draw ancestors by weight, but so that every cluster has some.

    Parameters
    ----------
    particles, clusters : Particles, Clusters
        The belief after the frame before.
    count : int
        Number of ancestors.
    resample : ResamplingScheme
        Resampling scheme.
    rng : numpy.random.Generator
        The source of randomness.
    """
    # The particles of no cluster have the label -1, so that theirs is the last factor.
    masses = [*clusters.masses.tolist(), clusters.rest]
    factors = np.array([_factor_for(mass) for mass in masses])[clusters.labels]
    frequencies = particles.weights * factors
    indices = resample(frequencies / frequencies.sum(), count, rng)
    weights = 1.0 / factors[indices]
    return Ancestors(particles.states[indices], weights / weights.sum())


def _factor_for(mass: float) -> float:
    """Return the oversampling factor of a cluster, at least 1; 0 for an empty one."""
    return max(mass, SMALLEST_CLUSTER_SHARE) / mass if mass > SMALLEST_MASS else 0.0


def survival_rates(parameters: TrackerParameters, image_width: int) -> SurvivalRates:
    """Return how often a cable leaves frames of a given width [px]."""
    return SurvivalRates(
        vanishing=parameters.disappearance_rate,
        leaving=parameters.leaving_rate,
        margin=parameters.leaving_margin * image_width / REFERENCE_WIDTH,
    )


def surviving_ancestors(
    ancestors: Ancestors,
    reference_angle: float,
    image_size: tuple[int, int],
    rates: SurvivalRates,
    dt: float,
) -> tuple[Ancestors, float]:
    """Return the ancestors reweighted by their survival, and the total survival probability.

    Each is weighted by its probability of staying in view for `dt`.

    Parameters
    ----------
    ancestors : Ancestors
        Ancestors with their weights after the frame before.
    reference_angle : float
        Angle within pi/2 of which their normals are written [rad].
    image_size : (int, int)
        Width and height of the frames [px].
    rates : SurvivalRates
        Rates at which a cable goes out of view.
    dt : float
        Time to the next frame [s].
    """
    states, weights = ancestors.states.copy(), ancestors.weights.copy()
    size = float(image_size[0]), float(image_size[1])
    survival = _survive(states, weights, reference_angle, size, rates, dt)
    return Ancestors(states, weights), survival


@compiled
def _survive(
    states: FloatArray,
    weights: FloatArray,
    reference_angle: float,
    image_size: tuple[float, float],
    rates: SurvivalRates,
    dt: float,
) -> float:
    """Write ancestors in a chart, and weigh them by their survival; return that of any of them."""
    survival = 0.0
    for row in range(len(weights)):
        state = states[row]
        state_in_chart(state, reference_angle, state)
        inside = image_reach(state[ANGLE], image_size[0], image_size[1]) - abs(state[DISTANCE])
        surviving = weights[row] * survival_probability(inside, rates, dt)
        weights[row] = max(surviving, LEAST_SURVIVING)
        survival += weights[row]
    for row in range(len(weights)):
        weights[row] /= survival
    return survival
