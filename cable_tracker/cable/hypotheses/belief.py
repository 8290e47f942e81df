"""State of the filter of several hypotheses after a frame, and its update.

What follows from it for the estimate and its status is worked out in `belief_summary`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.conclude.conclusion import (
    Conclusion,
    Hypotheses,
    unmeasured_hypotheses,
)
from cable_tracker.cable.hypotheses.conclude.first_claim import (
    is_lost_in_map,
    is_new_clear,
    leading_evidence,
)
from cable_tracker.cable.hypotheses.conclude.vehicle_fixture import UNTESTED, FixtureTest
from cable_tracker.cable.hypotheses.predict.remembered_cable import RememberedCable, remember
from cable_tracker.cable.hypotheses.weigh.clusters import NO_CLUSTER, Clusters
from cable_tracker.cable.hypotheses.weigh.presence import (
    LEAST_PRESENCE,
    LIKELY_PRESENCE,
    LOWEST,
)
from cable_tracker.cable.measure.map.cable_map import NO_KEPT_MAP, KeptMap
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.statistics import cable_mean_and_covariance
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import log_odds_of, probability_of
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.tracking.rates import over_time

MEMORY_PRESENCE, MEMORY_MASS = 0.9, 0.7
"""Minimum presence and minimum mass of the leading cluster for updating the memory."""

POLARITY_DOUBT = 0.02
"""The probability that the cable is bright stays this far from 0 and 1."""


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
        Time for which presence has been high in consecutive frames, but the weaker border too faint
        to claim the cable, or to keep a known one [s]. At `search_time` the search begins anew.
    evidence : float
        Evidence for the leading hypothesis, see `leading_evidence` [nats per point].
    is_clear : bool
        Whether the leading hypothesis is clear enough to claim it where nothing was known of it.
    known_time : float
        Time for which presence of the leading hypothesis has been at least 0.5 in consecutive
        frames, counted while its borders are clear enough to claim it [s]. From the parameter
        `known_after` on it is known.
    is_given : bool
        Whether an operator or planner gave the leading hypothesis, and presence has been at least
        0.5 in every frame since: it is known from the beginning.
    kept_map : KeptMap
        The last map of a picture, while the hypothesis that led in that frame goes on; else
        `NO_KEPT_MAP`.
    fixture_test : FixtureTest
        Whether that hypothesis is fixed to the vehicle.
    event : str
        Event of the frame for logs and reports; mostly empty.
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
    kept_map: KeptMap = NO_KEPT_MAP
    fixture_test: FixtureTest = UNTESTED
    event: str = ""

    def aged(self, dt: float) -> Belief:
        """Return the belief with the ages of memory and kept map `dt` seconds later."""
        memory, kept_map = self.memory, self.kept_map
        if memory is not None:
            memory = replace(memory, seconds=memory.seconds + dt)
        kept_map = replace(kept_map, seconds=kept_map.seconds + dt)
        return replace(self, memory=memory, kept_map=kept_map)

    @property
    def is_followed(self) -> bool:
        """Whether the leading hypothesis was given, or its known time has begun."""
        return self.is_given or self.known_time > 0.0

    def is_known(self, known_after: float) -> bool:
        """Tell whether the leading hypothesis is known; `known_after` is the parameter [s].

        With `known_after` 0 the known time must have begun, too.
        """
        return self.is_given or (self.known_time > 0.0 and self.known_time >= known_after)


def initial_belief(states: FloatArray, presence: float) -> Belief:
    """Return a belief of equally weighted states (N, 8), all of them one hypothesis."""
    particles = Particles.equally_weighted(wrap_states(states))
    mean, covariance = cable_mean_and_covariance(particles.states, particles.weights)
    labels = np.zeros(particles.count, np.int64)
    clusters = Clusters(labels, np.ones(1), mean[None, :], 0.0)
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
        particles=belief.particles.selected(indices),
        hypotheses=belief.hypotheses._replace(clusters=clusters, effective_size=float(count)),
    )


def updated_belief(
    before: Belief,
    conclusion: Conclusion,
    dt: float,
    parameters: TrackerParameters,
    image_size: tuple[int, int],
    frame_scale: float,
    *,
    was_known: bool,
) -> Belief:
    """Return the belief after a frame.

    Parameters
    ----------
    before : Belief
        Belief before the frame, aged to its time.
    conclusion : Conclusion
        Particles, clusters and log-odds after the frame, at least one cluster.
    dt : float
        Time since the frame before [s].
    parameters : TrackerParameters
        The tracker's parameters.
    image_size : (int, int)
        Width and height of the frames [px].
    frame_scale : float
        See `WorkingImage`.
    was_known : bool
        Whether the hypothesis that led before the frame was known.
    """
    hypotheses = conclusion.hypotheses
    presence = probability_of(float(conclusion.log_odds[0]))
    is_known = conclusion.goes_on and was_known
    is_followed = conclusion.goes_on and before.is_followed
    is_clear = is_new_clear(hypotheses, before.memory, parameters, image_size, frame_scale) and (
        is_followed or not is_lost_in_map(hypotheses, parameters)
    )
    evidence = leading_evidence(hypotheses, parameters)
    # Place, width and polarity are learnt only from what could be claimed.
    is_learnt_from = is_known or is_clear
    believed = presence if is_learnt_from else 0.0
    memory = before.memory
    if believed >= MEMORY_PRESENCE and hypotheses.clusters.masses[0] >= MEMORY_MASS:
        leader = hypotheses.clusters.means[0]
        memory = remember(memory, leader, image_size, dt, parameters, frame_scale)
    p_bright = updated_p_bright(
        before.p_bright, conclusion.p_bright, believed, parameters.polarity_memory, dt
    )
    # Too faint to claim, or, if it is known, to keep.
    is_faint = evidence < parameters.evidence_to_lose if is_known else not is_clear
    is_too_faint = is_faint and presence >= parameters.presence_to_track
    stays_likely = conclusion.goes_on and presence >= LIKELY_PRESENCE
    return Belief(
        particles=Particles(conclusion.states, conclusion.log_weights),
        hypotheses=hypotheses,
        presence=presence,
        p_bright=p_bright,
        memory=memory,
        log_odds=conclusion.log_odds,
        faint_time=before.faint_time + dt if is_too_faint else 0.0,
        evidence=evidence,
        is_clear=is_clear,
        known_time=before.known_time + (dt if is_learnt_from else 0.0) if stays_likely else 0.0,
        is_given=before.is_given and stays_likely,
        kept_map=before.kept_map if conclusion.goes_on else NO_KEPT_MAP,
        fixture_test=before.fixture_test,
    )


def without_fixture(belief: Belief, event: str) -> Belief:
    """Return a belief whose leading hypothesis is no cable: it is fixed to the vehicle."""
    log_odds = belief.log_odds.copy()
    log_odds[0] = LOWEST
    return replace(
        belief, presence=LEAST_PRESENCE, log_odds=log_odds, is_clear=False, known_time=0.0,
        is_given=False, faint_time=0.0, event=event,
    )  # fmt: skip


def updated_p_bright(
    before: float, found: float, presence: float, memory: float, dt: float
) -> float:
    """Return the probability that the cable is bright, `dt` seconds after one `before`.

    `found`: share of the particles' weight that speaks for a bright cable; it counts as far as
    there is one, `presence`. `memory`: factor on the deviation from 0.5 per frame of 25 per second.
    """
    kept = over_time(memory, dt)
    now = presence * found + (1.0 - presence) * before
    p_bright = kept * now + (1.0 - kept) * 0.5
    return float(min(max(p_bright, POLARITY_DOUBT), 1.0 - POLARITY_DOUBT))
