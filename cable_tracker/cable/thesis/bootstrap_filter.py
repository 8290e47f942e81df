"""The filter of the thesis: resample if needed, move, weigh, estimate (chapter 4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.filter_interface import BeliefSummary, ParticleBelief
from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.borders.response_table import ResponseTable
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.initial_state import random_states
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.model.statistics import cable_mean_and_covariance
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.thesis.border_response_model import BorderResponseModel
from cable_tracker.cable.thesis.movement import LimitedMovement
from cable_tracker.particle_filter.particles import (
    RESAMPLING_SCHEMES,
    Particles,
    effective_sample_size,
)

Observation: TypeAlias = BorderResponseModel | BorderLikelihoodRatio


def make_observation(parameters: TrackerParameters, table: ResponseTable) -> Observation:
    """Return the observation model that the parameters name."""
    if parameters.observation == "likelihood_ratio":
        return BorderLikelihoodRatio(parameters, table)
    return BorderResponseModel(parameters)


@dataclass(frozen=True, slots=True, eq=False)
class BootstrapBelief:
    """What the filter of the thesis believes: weighted particles.

    Whether they began as what an operator or planner gave is kept for the claim alone.
    """

    particles: Particles
    is_given: bool = False


class BootstrapFilter:
    """Sequential importance resampling with either observation model. It holds no belief itself.

    Parameters
    ----------
    parameters : TrackerParameters
        The tracker's parameters.
    observation : Observation
        Observation model, which gives the log-likelihoods of cables in a frame.
    image_width : int
        Width of the frames [px].
    rng : numpy.random.Generator
        The only source of randomness.
    """

    def __init__(
        self,
        parameters: TrackerParameters,
        observation: Observation,
        image_width: int,
        rng: np.random.Generator,
    ) -> None:
        self.search_time = parameters.search_time
        self._parameters = parameters
        self._observation = observation
        self._width = image_width
        self._rng = rng
        self._movement = LimitedMovement(parameters, image_width)
        self._resample = RESAMPLING_SCHEMES[parameters.resampling]

    def first_belief(self) -> BootstrapBelief:
        """Return particles all over the search box."""
        states = random_states(self._parameters, self._width, self._rng)
        return self.given_belief(states, is_certain=False)

    def given_belief(self, states: FloatArray, *, is_certain: bool = True) -> BootstrapBelief:
        """Return equally weighted particles, states (N, 8); if not certain, as a guess."""
        return BootstrapBelief(Particles.equally_weighted(states), is_certain)

    def converted(self, belief: ParticleBelief) -> BootstrapBelief:
        """Return the belief of any filter as this one's, with as many particles as wanted."""
        particles, count = belief.particles, self._parameters.particle_count
        if particles.count != count:
            particles = particles.selected(self._resample(particles.weights, count, self._rng))
        return BootstrapBelief(particles, belief.is_given)

    def step(
        self,
        belief: BootstrapBelief,
        image: WorkingImage,
        dt: float,
        detections: FloatArray,
        motion: MotionAid | None = None,
    ) -> BootstrapBelief:
        """Return the belief after one more frame; see `MultiHypothesisFilter.step`.

        It asks no detector.
        """
        particles = self._resampled(belief.particles)
        if dt > 0.0:
            moved = self._movement.propagate(particles.states, dt, self._rng, motion)
            particles = particles.moved_to(moved)
        log_likelihoods = self._observation.log_likelihoods(particles.states, image)
        return BootstrapBelief(particles.reweighted(log_likelihoods), belief.is_given)

    def _resampled(self, particles: Particles) -> Particles:
        """Resample if N_eff has fallen below the threshold.

        Otherwise the particles keep their weights, so that the next likelihood multiplies them.
        """
        size = effective_sample_size(particles.log_weights)
        if size >= self._parameters.resampling_threshold * particles.count:
            return particles
        return particles.selected(self._resample(particles.weights, particles.count, self._rng))

    def summary(self, belief: BootstrapBelief, image: WorkingImage) -> BeliefSummary:
        """Return mean and covariance of the particles, and how clearly the frame shows the mean."""
        particles = belief.particles
        mean, covariance = cable_mean_and_covariance(particles.states, particles.weights)
        evidence = self._observation.evidence(mean, image)
        is_clear = evidence >= self._parameters.evidence_to_track
        return BeliefSummary(
            covariance=covariance,
            effective_sample_size=effective_sample_size(particles.log_weights),
            evidence=evidence,
            supports_claim=is_clear,
            supports_new_claim=is_clear,
            follows_given=belief.is_given,
            supports_keeping=evidence >= self._parameters.evidence_to_lose,
            hypotheses=(Hypothesis(1.0, CableState.from_array(mean)),),
        )
