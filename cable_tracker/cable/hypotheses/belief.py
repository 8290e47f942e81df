"""What the filter of several hypotheses believes after a frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.clusters import Clusters, find_clusters
from cable_tracker.cable.hypotheses.presence import log_odds_of
from cable_tracker.cable.hypotheses.survival_and_birth import RememberedCable
from cable_tracker.cable.hypotheses.width_prior import WidthPrior
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.state import StateColumn
from cable_tracker.particle_filter.particles import Particles


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """What the filter believes after a frame. Never changed in place.

    Attributes
    ----------
    particles : Particles
        Where the cable is, given that there is one; angles in (-pi/2, pi/2].
    clusters : Clusters
        Of the particles.
    covariance : FloatArray
        Of the leading cluster, in the chart about its mean, shape (8, 8).
    effective_size : float
        N_eff of all particles.
    presence : float
        Probability that there is a cable in view.
    p_bright : float
        Probability that it is brighter than the bottom.
    memory : RememberedCable or None
        Where a cable was last tracked.
    width_prior : WidthPrior or None
        How wide it was.
    border_evidence : float
        Mean log-likelihood ratio per point of the weaker border, over the leading cluster.
    visible_length : float
        Length inside the image of the shorter border, over the leading cluster [distances of the
        scan lines].
    log_odds : FloatArray
        That each cluster is a cable, shape (K,).
    refused_time : float
        How long a cable has been present whose weaker border cannot be seen [s].
    """

    particles: Particles
    clusters: Clusters
    covariance: FloatArray
    effective_size: float
    presence: float
    p_bright: float = 0.5
    memory: RememberedCable | None = None
    width_prior: WidthPrior | None = None
    border_evidence: float = 0.0
    visible_length: float = 0.0
    log_odds: FloatArray = field(default_factory=lambda: np.empty(0))
    refused_time: float = 0.0

    @property
    def reference_angle(self) -> float:
        """Angle of the leading cluster [rad]: the middle of the chart."""
        return float(self.clusters.means[0, StateColumn.ANGLE])


def initial_belief(states: FloatArray, presence: float, image_width: int) -> Belief:
    """Return a belief of equally weighted states (N, 8)."""
    particles = Particles.equally_weighted(wrap_states(states))
    clusters, covariance = find_clusters(
        particles.states, particles.log_weights, float(image_width)
    )
    log_odds = np.full(len(clusters.masses), log_odds_of(presence))
    return Belief(particles, clusters, covariance, float(len(states)), presence, log_odds=log_odds)
