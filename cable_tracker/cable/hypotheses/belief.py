"""What the filter of several hypotheses believes after a frame."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.clusters import Cluster, find_clusters
from cable_tracker.cable.hypotheses.leaving import RememberedCable
from cable_tracker.cable.hypotheses.usual_width import UsualWidth
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
    clusters : tuple of Cluster
        Of the particles, heaviest first.
    presence : float
        Probability that there is a cable in view.
    bright : float
        Probability that it is brighter than the bottom.
    memory : RememberedCable or None
        Where a cable was last tracked.
    usual_width : UsualWidth or None
        How wide it was.
    evidence : float
        Mean log-likelihood ratio per point of the weaker border, over the leading cluster.
    seen : float
        Points inside the image of the border that has fewer, over the leading cluster.
    """

    particles: Particles
    clusters: tuple[Cluster, ...]
    presence: float
    bright: float = 0.5
    memory: RememberedCable | None = None
    usual_width: UsualWidth | None = None
    evidence: float = 0.0
    seen: float = 0.0

    @property
    def reference_angle(self) -> float:
        """Angle of the leading cluster [rad]: the middle of the chart."""
        return float(self.clusters[0].mean[StateColumn.ANGLE])


def initial_belief(states: FloatArray, presence: float, image_width: int) -> Belief:
    """Return a belief of equally weighted states (N, 8)."""
    particles = Particles.equally_weighted(wrap_states(states))
    clusters = find_clusters(particles.states, particles.weights, image_width)
    return Belief(particles, tuple(clusters), presence)
