"""State of the filter of several hypotheses after a frame, with the cable it remembers.

What is remembered is pose and width of the cable when it was last tracked. The width changes
slowly, as the diameter of a cable and the altitude of a vehicle do. So a rope beside a cable that
is overgrown just here is not taken for it, however clear its borders are.

How a belief changes with a frame, and what follows for the claim, is worked out in `claim`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.clusters import NO_CLUSTER, Clusters
from cable_tracker.cable.hypotheses.predicted_density import NARROWEST
from cable_tracker.cable.hypotheses.presence import (
    LEAST_PRESENCE,
    LIKELY_PRESENCE,
    LOWEST,
    is_same_hypothesis,
)
from cable_tracker.cable.hypotheses.vehicle_fixture import UNTESTED, FixtureTest
from cable_tracker.cable.measure.map.cable_map import NO_KEPT_MAP, KeptMap
from cable_tracker.cable.model.geometry import inset, wrap_state, wrap_states
from cable_tracker.cable.model.state import DISTANCE, POSE_SIZE, WIDTH, pose_units
from cable_tracker.cable.model.statistics import cable_mean_and_covariance
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled_part
from cable_tracker.particle_filter.existence import log_odds_of
from cable_tracker.particle_filter.particles import Particles

SPREAD = np.array([4.0, math.radians(2.0), 3.0, math.radians(1.0)])
"""Scales of the search about the last place, at first: d, alpha, w, beta [px at the reference
width, rad]."""

SPREADING = np.array([100.0, math.radians(37.0), 50.0, math.radians(7.5)])
"""Growth of these scales per second [px/s at the reference width, rad/s]."""

WIDEST = np.array([120.0, math.radians(60.0), 40.0, math.radians(10.0)])
"""Largest spread about the last place; a cable farther away is found by the uninformed search."""

LEFT_MARGIN = 3.0
"""A cable was leaving if it was nearer to the edge than this many `leaving_margin`."""

YOUNG_DOUBT = 3.0
"""Increase of the width prior's relative scale at first, decaying with `width_time`."""


FAMILIAR = 2.0
"""Largest difference from the remembered cable, in scales of its place and spreads of its width."""


@dataclass(frozen=True, slots=True, eq=False)
class RememberedCable:
    """Pose of the cable when it was last tracked, and the prior of its width.

    Attributes
    ----------
    pose : FloatArray
        d, alpha, w, beta, shape (4,) [px, rad].
    side : float
        Sign of d if it was leaving the image there; 0 if it was not.
    inset : float
        How far it was from leaving the image [px].
    log_width : float
        Logarithm of the running mean of the width while it was tracked [px].
    tracked_time : float
        Total time for which it was tracked [s].
    seconds : float
        Time since it was last tracked [s].
    """

    pose: FloatArray
    side: float
    inset: float
    log_width: float
    tracked_time: float = 0.0
    seconds: float = 0.0

    def scales(self, frame_scale: float) -> FloatArray:
        """Return the scales of births about the remembered pose, shape (4,) [px, rad].

        `frame_scale`: see `WorkingImage`.
        """
        scales = np.minimum(SPREAD + SPREADING * self.seconds, WIDEST)
        scaled: FloatArray = scales * pose_units(frame_scale)
        return scaled

    def width_spread(self, parameters: TrackerParameters) -> float:
        """Return the scale of the logarithm of the width, in the width prior.

        It grows with the time since the cable was tracked, and falls with the time for which it
        was.
        """
        doubt = YOUNG_DOUBT * math.exp(-self.tracked_time / parameters.width_time)
        growth = self.seconds / parameters.width_memory
        return parameters.width_spread * (1.0 + doubt + growth)

    def width_deviation(self, width: float, parameters: TrackerParameters) -> float:
        """Return the deviation of a width [px] from the prior: of its logarithm, in scales."""
        difference = math.log(max(width, NARROWEST)) - self.log_width
        return difference / self.width_spread(parameters)


def remember(
    before: RememberedCable | None,
    leader: FloatArray,
    image_size: tuple[int, int],
    dt: float,
    parameters: TrackerParameters,
    frame_scale: float,
) -> RememberedCable:
    """Return the memory after a frame in which a cable is tracked.

    Parameters
    ----------
    before : RememberedCable or None
        The memory before the frame.
    leader : FloatArray
        State of the cable, shape (8,).
    image_size : (int, int)
        Width and height of the frames [px].
    dt : float
        Time since the frame before [s].
    parameters : TrackerParameters
        The tracker's parameters.
    frame_scale : float
        See `WorkingImage`.
    """
    state = wrap_state(leader)
    log_width, tracked_time = math.log(max(float(state[WIDTH]), NARROWEST)), 0.0
    if before is not None:
        share = -math.expm1(-dt / parameters.width_time)
        log_width = before.log_width + share * (log_width - before.log_width)
        tracked_time = before.tracked_time + dt
    within = inset(state, *image_size)
    is_leaving = within < LEFT_MARGIN * parameters.leaving_margin * frame_scale
    return RememberedCable(
        pose=state[:POSE_SIZE].copy(),
        side=float(np.sign(state[DISTANCE])) if is_leaving else 0.0,
        inset=within,
        log_width=log_width,
        tracked_time=tracked_time,
    )


class Hypotheses(NamedTuple):
    """The clusters of the particles, and how the frame shows the leading one.

    Attributes
    ----------
    clusters : Clusters
        Clusters of the particles, the most probable cable first, see `most_probable_first`.
    covariance : FloatArray
        Covariance of the leading cluster, its particles in the chart about its mean's angle, shape
        (8, 8).
    effective_size : float
        Effective sample size N_eff of all particles.
    weaker_border_mean : float
        Mean log-likelihood ratio per point of the weaker border, averaged over the leading cluster
        [nats]: the evidence of the borders alone. What is published is `leading_evidence`.
    visible_length : float
        Length inside the image of the shorter border, over the leading cluster [distances of the
        scan lines].
    leading_mean_borders : FloatArray
        Mean log-likelihood ratios per point of the left and of the right border of the leading
        mean, shape (2,) [nats].
    scaled_clearness : float
        Clearness of the weaker border of the leading mean (`BorderClearness.clearness`, nats per
        visible point) times `shown_share`; 0 for borders shorter than `LEAST_SHOWN`.
    appearance : float
        How much the leading group looks like a cable, see `appearances_of` [nats].
    is_mapped : bool
        Whether a map, of the frame or kept, has a say in that.
    overlap_share : float
        Overlap of the leading mean with that map, see `MapMatch`; 0 without one.
    """

    clusters: Clusters
    covariance: FloatArray
    effective_size: float
    weaker_border_mean: float
    visible_length: float
    leading_mean_borders: FloatArray
    scaled_clearness: float
    appearance: float
    is_mapped: bool
    overlap_share: float


@compiled_part
def unmeasured_hypotheses(
    clusters: Clusters, covariance: FloatArray, effective_size: float
) -> Hypotheses:
    """Return clusters of which no frame has shown anything."""
    return Hypotheses(
        clusters=clusters,
        covariance=covariance,
        effective_size=effective_size,
        weaker_border_mean=0.0,
        visible_length=0.0,
        leading_mean_borders=np.zeros(2),
        scaled_clearness=0.0,
        appearance=0.0,
        is_mapped=False,
        overlap_share=0.0,
    )


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

    def is_too_faint(self, parameters: TrackerParameters) -> bool:
        """Tell whether the search begins anew with the next frame, see `faint_time`."""
        return self.faint_time >= parameters.search_time

    def is_searching(self, parameters: TrackerParameters) -> bool:
        """Tell whether presence is below 0.5, or the search begins anew with the next frame."""
        return self.presence < LIKELY_PRESENCE or self.is_too_faint(parameters)

    def is_known(self, parameters: TrackerParameters) -> bool:
        """Tell whether the leading hypothesis is known, and no search begins anew.

        With the parameter `known_after` 0 the known time must have begun, too.
        """
        if self.is_too_faint(parameters):
            return False
        return self.is_given or (
            self.known_time > 0.0 and self.known_time >= parameters.known_after
        )


def is_familiar(belief: Belief, parameters: TrackerParameters, frame_scale: float) -> bool:
    """Tell whether the leader may be the cable that was tracked.

    It is the one of the frames before, or lies where that may be by now, and is about as wide.
    """
    if belief.is_followed:
        return True
    memory = belief.memory
    if memory is None:
        return False
    leader = belief.hypotheses.clusters.means[0]
    width = float(leader[WIDTH])
    if abs(memory.width_deviation(width, parameters)) > FAMILIAR:
        return False
    return is_same_hypothesis(leader, memory.pose, FAMILIAR * memory.scales(frame_scale))


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


def without_fixture(belief: Belief, event: str) -> Belief:
    """Return a belief whose leading hypothesis is no cable: it is fixed to the vehicle."""
    log_odds = belief.log_odds.copy()
    log_odds[0] = LOWEST
    return replace(
        belief, presence=LEAST_PRESENCE, log_odds=log_odds, is_clear=False, known_time=0.0,
        is_given=False, faint_time=0.0, event=event,
    )  # fmt: skip
