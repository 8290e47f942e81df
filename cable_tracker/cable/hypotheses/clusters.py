"""Clusters of particles: the places where the cable may be.

The heaviest particle gathers those about it; of the rest the heaviest gathers again. Two cables, or
a cable and its shadow, come out as two clusters, and a mean is never taken across them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.geometry import unwrap_states, wrap_state
from cable_tracker.cable.model.state import PLACES, StateColumn
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH
from cable_tracker.particle_filter.estimates import weighted_covariance, weighted_mean

RADII = np.array([24.0, np.deg2rad(12.0), 30.0, np.deg2rad(10.0)])
"""Half-axes of the ellipsoid that a cluster fills at most: d, alpha, w, beta [px at the reference
width, rad]."""

MOST_CLUSTERS = 5

SMALLEST_MASS = 1e-9
"""What has less than this share of the weight is not worth a name."""

CENTRINGS = 2
"""How often a cluster is gathered anew about its own mean."""


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """A cluster of particles.

    Attributes
    ----------
    mass : float
        Sum of their weights.
    mean : FloatArray
        Their weighted mean, shape (8,); its angle is not wrapped.
    members : BoolArray
        Which particles belong to it, shape (N,).
    """

    mass: float
    mean: FloatArray
    members: BoolArray

    @property
    def state(self) -> FloatArray:
        """The mean with its angle in (-pi/2, pi/2], shape (8,)."""
        return wrap_state(self.mean)

    def covariance(self, states: FloatArray, weights: FloatArray) -> FloatArray:
        """Return the covariance (8, 8) of its particles, of all states (N, 8) and weights (N,)."""
        chart = unwrap_states(states[self.members], float(self.mean[StateColumn.ANGLE]))
        share = weights[self.members] / self.mass
        return weighted_covariance(chart, share, self.mean)


def find_clusters(states: FloatArray, weights: FloatArray, image_width: int) -> list[Cluster]:
    """Return the clusters of particles, heaviest first; at least one.

    Parameters
    ----------
    states : FloatArray
        Shape (N, 8).
    weights : FloatArray
        Shape (N,), summing to one.
    image_width : int
        Width of the frames [px].
    """
    with np.errstate(divide="ignore"):
        log_weights = np.log(weights)
    return clusters_of(find_groups(states, log_weights, image_width), states, weights)


def clusters_of(
    groups: Sequence[BoolArray], states: FloatArray, weights: FloatArray
) -> list[Cluster]:
    """Return the groups of particles as clusters, heaviest first, without those that weigh nothing.

    Parameters
    ----------
    groups : sequence of BoolArray
        Members of each, shape (N,).
    states, weights : FloatArray
        Shapes (N, 8) and (N,); the weights sum to one.
    """
    clusters = []
    for members in groups:
        mass = float(weights[members].sum())
        if mass <= SMALLEST_MASS:
            continue
        heaviest = states[members][int(np.argmax(weights[members]))]
        chart = unwrap_states(states[members], float(heaviest[StateColumn.ANGLE]))
        clusters.append(Cluster(mass, weighted_mean(chart, weights[members] / mass), members))
    return sorted(clusters, key=lambda cluster: -cluster.mass)


def find_groups(
    states: FloatArray,
    log_weights: FloatArray,
    image_width: int,
    anchor: FloatArray | None = None,
) -> list[BoolArray]:
    """Return the members of each cluster, shape (N,), in the order in which they were found.

    However light what is left, it gathers: in logarithms no weight is too small to compare.

    Parameters
    ----------
    states : FloatArray
        Shape (N, 8).
    log_weights : FloatArray
        Shape (N,); particles of weight zero (-inf) belong to none.
    image_width : int
        Width of the frames [px].
    anchor : FloatArray or None
        Where the first cluster is looked for, shape (8,); at the heaviest particle if None.
    """
    scale = image_width / REFERENCE_WIDTH
    radii = RADII * np.array([scale, 1.0, scale, 1.0])
    left = log_weights.copy()
    groups: list[BoolArray] = []
    if anchor is not None:
        _take(_gather(states, left, radii, anchor), left, groups)
    while len(groups) < MOST_CLUSTERS and np.isfinite(left).any():
        heaviest = states[int(np.argmax(left))]
        _take(_gather(states, left, radii, heaviest), left, groups)
    return groups


def _take(members: BoolArray, left: FloatArray, groups: list[BoolArray]) -> None:
    if members.any():
        groups.append(members)
        left[members] = -np.inf


def _gather(
    states: FloatArray, log_weights: FloatArray, radii: FloatArray, centre: FloatArray
) -> BoolArray:
    possible = np.isfinite(log_weights)
    mean = centre
    members = np.zeros(len(states), bool)
    for _ in range(CENTRINGS):
        chart = unwrap_states(states, float(mean[StateColumn.ANGLE]))
        apart = (chart[:, :PLACES] - mean[:PLACES]) / radii
        gathered = ((apart**2).sum(axis=1) <= 1.0) & possible
        if not gathered.any():
            # The mean of a ring may lie on none of its particles; they stay together.
            break
        members = gathered
        weights = np.exp(log_weights[members] - log_weights[members].max())
        mean = weighted_mean(chart[members], weights / weights.sum())
    return members
