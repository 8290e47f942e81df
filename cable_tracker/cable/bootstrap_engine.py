"""The filter of the thesis: particles move by themselves and are weighed by the frame."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.engine import Finding, TrackingEngine
from cable_tracker.cable.estimate import Hypothesis, TrackingStatus
from cable_tracker.cable.evidence import border_evidence
from cable_tracker.cable.initialisation import random_states
from cable_tracker.cable.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.movement import CableMovement
from cable_tracker.cable.observation import BorderObservation
from cable_tracker.cable.parameters import TrackerParameters
from cable_tracker.cable.proposer import CableProposer
from cable_tracker.cable.response_table import ResponseTable
from cable_tracker.cable.state import CableState
from cable_tracker.cable.statistics import cable_mean_and_covariance
from cable_tracker.cable.status import StatusMachine
from cable_tracker.cable.working_image import WorkingImage
from cable_tracker.particle_filter.filter import ParticleFilter
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.particle_filter.weights import effective_sample_size


class BootstrapEngine:
    """Sequential importance resampling with either observation model (thesis, chapter 4).

    Parameters
    ----------
    parameters : TrackerParameters
        All of them.
    table : ResponseTable
        For the observation `likelihood_ratio`.
    rng : numpy.random.Generator
        The only source of randomness.
    """

    def __init__(
        self, parameters: TrackerParameters, table: ResponseTable, rng: np.random.Generator
    ) -> None:
        self._parameters = parameters
        self._rng = rng
        self._responses = BorderObservation(parameters)
        self._observation: BorderObservation | BorderLikelihoodRatio = (
            BorderLikelihoodRatio(parameters, table)
            if parameters.observation == "likelihood_ratio"
            else self._responses
        )
        self._filter: ParticleFilter[WorkingImage] | None = None

    @property
    def particles(self) -> Particles | None:
        """The present belief; None before the first frame."""
        return self._filter.particles if self._filter else None

    def use(self, proposer: CableProposer) -> None:
        """Do nothing: this filter asks no detector."""

    def forget(self) -> None:
        """Drop the belief."""
        self._filter = None

    def take_over(self, other: TrackingEngine, image_size: tuple[int, int]) -> None:
        """Go on with the particles of another engine, in frames of this size [px]."""
        if other.particles is None:
            return
        self._filter = self._make_filter(other.particles, image_size[0])
        if other.particles.count != self._parameters.particle_count:
            self._filter.resample(self._parameters.particle_count)

    def start(self, states: FloatArray, image: WorkingImage, status: StatusMachine) -> Finding:
        """Look at a frame, believing in states (N, 8), equally."""
        particles = Particles.equally_weighted(states)
        self._filter = self._make_filter(particles, image.frame_size[0])
        return self._look(self._filter, image, status)

    def advance(self, image: WorkingImage, dt: float, status: StatusMachine) -> Finding:
        """Look at the next frame, `dt` seconds later."""
        if self._filter is None:
            return self.start(self._random(image), image, status)
        if self._is_search_due(status):
            self._filter = self._make_filter(
                Particles.equally_weighted(self._random(image)), image.frame_size[0]
            )
            status = status.searched()
        self._filter.resample_if_degenerate()
        self._filter.predict(dt)
        return self._look(self._filter, image, status)

    def _random(self, image: WorkingImage) -> FloatArray:
        return random_states(self._parameters, image.frame_size[0], self._rng)

    def _is_search_due(self, status: StatusMachine) -> bool:
        if status.status is TrackingStatus.TRACKING or status.is_confirming:
            return False
        return status.unclaimed_time >= self._parameters.search_time

    def _make_filter(self, particles: Particles, width: int) -> ParticleFilter[WorkingImage]:
        return ParticleFilter(
            particles,
            movement=CableMovement(self._parameters, width),
            observation=self._observation,
            resampling=RESAMPLING_SCHEMES[self._parameters.resampling],
            resampling_threshold=self._parameters.resampling_threshold,
            rng=self._rng,
        )

    def _look(
        self, cable_filter: ParticleFilter[WorkingImage], image: WorkingImage, status: StatusMachine
    ) -> Finding:
        cable_filter.update(image)
        particles = cable_filter.particles
        mean, covariance = cable_mean_and_covariance(particles.states, particles.weights)
        evidence = self._evidence(mean, image)
        return Finding(
            mean=mean,
            covariance=covariance,
            effective_sample_size=effective_sample_size(particles.log_weights),
            evidence=evidence,
            rises=evidence >= self._parameters.evidence_to_track,
            holds=evidence >= self._parameters.evidence_to_lose,
            status=status,
            hypotheses=(Hypothesis(1.0, CableState.from_array(mean)),),
        )

    def _evidence(self, mean: FloatArray, image: WorkingImage) -> float:
        if isinstance(self._observation, BorderLikelihoodRatio):
            return float(self._observation.measure(mean[None, :], image).weaker_borders.max())
        return border_evidence(self._responses, mean, image)
