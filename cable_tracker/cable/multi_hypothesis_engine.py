"""The filter of several hypotheses as the tracker uses it: its belief, its estimate, its claims."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.belief import Belief
from cable_tracker.cable.engine import Finding, TrackingEngine
from cable_tracker.cable.estimate import Hypothesis
from cable_tracker.cable.evidence import MINIMUM_POINTS
from cable_tracker.cable.geometry import SIGN_CHANGING_COLUMNS
from cable_tracker.cable.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.multi_hypothesis_filter import MultiHypothesisFilter
from cable_tracker.cable.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.cable.proposer import CableProposer
from cable_tracker.cable.response_table import ResponseTable
from cable_tracker.cable.state import PLACES, STATE_SIZE, CableState, StateColumn
from cable_tracker.cable.status import StatusMachine
from cable_tracker.cable.working_image import WorkingImage
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.particle_filter.weights import effective_sample_size

SMALLEST_HYPOTHESIS = 0.01
"""Clusters with a smaller share are not reported."""


BORDER_TURN = float(np.deg2rad(0.25))
"""Turn of a border that is displaced by one pixel of the reference width [rad]."""


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
        self._observation = BorderLikelihoodRatio(parameters, table)
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

    def advance(self, image: WorkingImage, dt: float, status: StatusMachine) -> Finding:
        """Look at the next frame, `dt` seconds later."""
        if self._filter is None:
            self._filter = self._make_filter(image.frame_size)
        belief = self._belief if self._belief is not None else self._filter.first_belief()
        return self._look(self._filter, belief, image, dt, status)

    def _make_filter(self, image_size: tuple[int, int]) -> MultiHypothesisFilter:
        return MultiHypothesisFilter(self._parameters, self._observation, image_size, self._rng)

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
        mean, covariance = self._leading_estimate(belief, image.frame_size[0])
        seen = belief.seen >= MINIMUM_POINTS
        return Finding(
            mean=mean,
            covariance=covariance,
            effective_sample_size=effective_sample_size(belief.particles.log_weights),
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

    def _leading_estimate(self, belief: Belief, image_width: int) -> tuple[FloatArray, FloatArray]:
        """Return mean (8,) and covariance (8, 8) of the leading cluster, never across clusters."""
        leader = belief.clusters[0]
        particles = belief.particles
        covariance = leader.covariance(particles.states, particles.weights)
        mean = leader.state
        turns = np.rint((leader.mean[StateColumn.ANGLE] - mean[StateColumn.ANGLE]) / np.pi)
        if turns % 2:
            signs = np.ones(STATE_SIZE)
            signs[list(SIGN_CHANGING_COLUMNS)] = -1.0
            covariance = covariance * np.outer(signs, signs)
        return mean, covariance + self._displacement(image_width)

    def _displacement(self, image_width: int) -> FloatArray:
        """Return the covariance (8, 8) of what the likelihood does not know.

        Growth, shadow and the roundness of a cable shift each border as a whole, by the same in
        frame after frame; particles agree on the wrong place then.
        """
        border = self._parameters.border_displacement * image_width / REFERENCE_WIDTH
        turn = self._parameters.border_displacement * BORDER_TURN
        variances = np.zeros(STATE_SIZE)
        # d and alpha are means of the two borders, w is their difference, beta half of it.
        variances[:PLACES] = [border**2 / 2, turn**2 / 2, 2 * border**2, turn**2 / 2]
        return np.diag(variances)


def _hypotheses(belief: Belief) -> tuple[Hypothesis, ...]:
    return tuple(
        Hypothesis(cluster.mass, CableState.from_array(cluster.state))
        for index, cluster in enumerate(belief.clusters)
        if index == 0 or cluster.mass >= SMALLEST_HYPOTHESIS
    )
