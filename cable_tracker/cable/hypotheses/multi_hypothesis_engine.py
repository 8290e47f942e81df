"""The filter of several hypotheses as the tracker uses it: its belief, its estimate, its claims."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.engine import Finding, TrackingEngine
from cable_tracker.cable.hypotheses.belief import Belief
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import MultiHypothesisFilter
from cable_tracker.cable.hypotheses.proposer import CableProposer
from cable_tracker.cable.kernels import make_likelihood_ratio, make_multi_hypothesis_filter
from cable_tracker.cable.measure.response_table import ResponseTable
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.geometry import SIGN_CHANGING_COLUMNS
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.state import STATE_SIZE, CableState, StateColumn
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.thesis.evidence import MINIMUM_POINTS
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.tracking.status import StatusMachine

SMALLEST_HYPOTHESIS = 0.01
"""Clusters with a smaller share are not reported."""


_SIGNS = np.ones(STATE_SIZE)
_SIGNS[list(SIGN_CHANGING_COLUMNS)] = -1.0
TURNED_SIGNS = np.outer(_SIGNS, _SIGNS)
"""Factors on a covariance (8, 8) when the normal is turned round."""


class MultiHypothesisEngine:
    """See `multi_hypothesis_filter`.

    Parameters
    ----------
    parameters : TrackerParameters
        All of them.
    table : ResponseTable
        Likelihood ratios of single points.
    proposer : CableProposer
        Asked for cables in every frame.
    rng : numpy.random.Generator
        The only source of randomness.
    """

    def __init__(
        self,
        parameters: TrackerParameters,
        table: ResponseTable,
        proposer: CableProposer,
        rng: np.random.Generator,
    ) -> None:
        self._parameters = parameters
        self._proposer = proposer
        self._rng = rng
        self._observation = make_likelihood_ratio(parameters, table)
        self._filter: MultiHypothesisFilter | None = None
        self._belief: Belief | None = None

    @property
    def particles(self) -> Particles | None:
        """The present belief about the cable, given that there is one; None before any frame."""
        return self._belief.particles if self._belief else None

    def use(self, proposer: CableProposer) -> None:
        """Ask this detector from now on."""
        self._proposer = proposer

    def forget(self) -> None:
        """Drop the belief."""
        self._filter = None
        self._belief = None

    def take_over(self, other: TrackingEngine, image_size: tuple[int, int]) -> None:
        """Go on with the belief of another engine, in frames of this size [px]."""
        self._filter = self._make_filter(image_size)
        if isinstance(other, MultiHypothesisEngine):
            self._belief = other._belief
        elif other.particles is not None:
            self._belief = self._filter.belief_given(self._drawn_from(other.particles))
        if self._belief is not None:
            self._belief = self._filter.adapted(self._belief)

    def _drawn_from(self, particles: Particles) -> FloatArray:
        resample = RESAMPLING_SCHEMES[self._parameters.resampling]
        return particles.states[resample(particles.weights, particles.count, self._rng)]

    def start(self, states: FloatArray, image: WorkingImage, status: StatusMachine) -> Finding:
        """Look at a frame, believing in states (N, 8), equally."""
        self._filter = self._make_filter(image.frame_size)
        return self._look(self._filter, self._filter.belief_given(states), image, 0.0, status)

    def advance(
        self,
        image: WorkingImage,
        dt: float,
        status: StatusMachine,
        motion: MotionAid | None = None,
    ) -> Finding:
        """Look at the next frame, `dt` seconds later; odometry may say how it has moved."""
        if self._filter is None:
            self._filter = self._make_filter(image.frame_size)
        belief = self._belief if self._belief is not None else self._filter.first_belief()
        self._filter.aid_by(motion)
        return self._look(self._filter, belief, image, dt, status)

    def _make_filter(self, image_size: tuple[int, int]) -> MultiHypothesisFilter:
        return make_multi_hypothesis_filter(
            self._parameters, self._observation, image_size, self._rng
        )

    def _look(
        self,
        cable_filter: MultiHypothesisFilter,
        before: Belief,
        image: WorkingImage,
        dt: float,
        status: StatusMachine,
    ) -> Finding:
        belief = cable_filter.step(before, image, dt, self._proposer.propose(image))
        self._belief = belief
        mean, covariance = self._leading_estimate(cable_filter, belief)
        seen = belief.seen >= MINIMUM_POINTS
        return Finding(
            mean=mean,
            covariance=covariance,
            effective_sample_size=cable_filter.effective_sample_size(belief),
            evidence=belief.evidence,
            rises=seen
            and belief.presence >= self._parameters.presence_to_track
            and belief.evidence >= self._parameters.evidence_to_track,
            holds=seen
            and belief.presence >= self._parameters.presence_to_lose
            and belief.evidence >= self._parameters.evidence_to_lose,
            status=status,
            presence=belief.presence,
            hypotheses=_hypotheses(belief),
        )

    def _leading_estimate(
        self, cable_filter: MultiHypothesisFilter, belief: Belief
    ) -> tuple[FloatArray, FloatArray]:
        """Return mean (8,) and covariance (8, 8) of the leading cluster, never across clusters."""
        leader = belief.clusters[0]
        covariance = cable_filter.leading_covariance(belief)
        mean = leader.state
        turns = round((leader.mean[StateColumn.ANGLE] - mean[StateColumn.ANGLE]) / math.pi)
        if turns % 2:
            covariance = covariance * TURNED_SIGNS
        return mean, covariance + cable_filter.displacement


def _hypotheses(belief: Belief) -> tuple[Hypothesis, ...]:
    return tuple(
        Hypothesis(cluster.mass, CableState.from_array(cluster.state))
        for index, cluster in enumerate(belief.clusters)
        if index == 0 or cluster.mass >= SMALLEST_HYPOTHESIS
    )
