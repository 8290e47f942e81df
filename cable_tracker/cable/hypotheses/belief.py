"""What the filter of several hypotheses believes after a frame.

What is said of the leading hypothesis, from what the belief holds to what the summary makes of it:

====================  ==============================================================================
`presence`            How likely it is a cable.
`is_given`            It was given, and every frame since has held it for a cable.
`known_time`          For how long it has been held for one and been clear enough to claim.
`is_followed`         It is given, or has such a time: frames before have held it for a cable.
`is_known`            It is given, or has been followed for `known_after`.
`faint_time`          For how long it has been present but too faint; at `search_time` it goes.
`is_clear`            Its borders are clear enough to claim it where nothing was known of it.
`is_familiar`         It is followed, or where the remembered cable may be, and about as wide.
`supports_keeping`    Visible, clear or familiar, presence and evidence not below `*_to_lose`.
`supports_claim`      The same, not below `*_to_track`.
`supports_new_claim`  The same, and clear.
`contradicts_claim`   Presence below `presence_to_lose`, or not what is remembered: lost at once
                      unless the frame also supports keeping.
====================  ==============================================================================

`is_familiar` and what a frame supports are those of `belief_summary`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.conclusion import Hypotheses, unmeasured_hypotheses
from cable_tracker.cable.hypotheses.predict.remembered_cable import RememberedCable
from cable_tracker.cable.hypotheses.weigh.clusters import NO_CLUSTER, Clusters
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.statistics import cable_mean_and_covariance
from cable_tracker.particle_filter.existence import log_odds_of
from cable_tracker.particle_filter.particles import Particles


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """Belief of the filter after a frame. Never changed in place.

    Attributes
    ----------
    particles : Particles
        Weighted states of the cable, given that there is one; angles in (-pi/2, pi/2].
    hypotheses : Hypotheses
        Clusters of the particles, and what the frame measures of the leading one.
    presence : float
        Probability that there is a cable in view.
    p_bright : float
        Probability that it is brighter than the bottom.
    memory : RememberedCable or None
        Pose of the cable when it was last tracked, the time since, and the prior of its width.
    log_odds : FloatArray
        Log-odds that each cluster is a cable, shape (K,) [nats].
    faint_time : float
        Time for which consecutive frames had a cable present, but its weaker border too faint to
        claim it, or, if it is known, to keep it [s].
    evidence : float
        Evidence for the leading hypothesis, see `leading_evidence` [nats per point].
    is_clear : bool
        Whether the leading hypothesis is clear enough to claim it where nothing was known of it.
    known_time : float
        Time for which consecutive frames held the leading hypothesis for a cable, counted while its
        borders are clear enough to claim it [s]. From the parameter `known_after` on it is known.
    is_given : bool
        Whether an operator or planner gave the leading hypothesis, and every frame since has held
        it for a cable: it is known from the beginning.
    """

    particles: Particles
    hypotheses: Hypotheses
    presence: float
    p_bright: float = 0.5
    memory: RememberedCable | None = None
    log_odds: FloatArray = field(default_factory=lambda: np.empty(0))
    faint_time: float = 0.0
    evidence: float = 0.0
    is_clear: bool = False
    known_time: float = 0.0
    is_given: bool = False

    @property
    def is_followed(self) -> bool:
        """Whether the leading hypothesis was given, or a frame before has held it for a cable."""
        return self.is_given or self.known_time > 0.0

    def is_known(self, known_after: float) -> bool:
        """Tell whether the leading hypothesis is known; `known_after` is the parameter [s].

        What no frame has held for a cable is not, however soon that may be.
        """
        return self.is_given or (self.known_time > 0.0 and self.known_time >= known_after)


def initial_belief(states: FloatArray, presence: float) -> Belief:
    """Return a belief of equally weighted states (N, 8), all of them one hypothesis."""
    particles = Particles.equally_weighted(wrap_states(states))
    mean, covariance = cable_mean_and_covariance(particles.states, particles.weights)
    labels = np.zeros(particles.count, np.int64)
    clusters = Clusters(labels, np.ones(1), mean[None, :], np.zeros(1, np.int64), 0.0)
    hypotheses = unmeasured_hypotheses(clusters, covariance, float(len(states)))
    return Belief(particles, hypotheses, presence, log_odds=np.full(1, log_odds_of(presence)))


def resampled_belief(belief: Belief, indices: IndexArray) -> Belief:
    """Return a belief in the particles that were drawn from it, (N,), equally weighted."""
    before, count = belief.hypotheses.clusters, len(indices)
    labels = before.labels[indices]
    clusters = before._replace(
        labels=labels,
        masses=np.bincount(labels[labels != NO_CLUSTER], minlength=len(before.masses)) / count,
        rest=float(np.mean(labels == NO_CLUSTER)),
    )
    return replace(
        belief,
        particles=Particles.equally_weighted(belief.particles.states[indices]),
        hypotheses=belief.hypotheses._replace(clusters=clusters, effective_size=float(count)),
    )
