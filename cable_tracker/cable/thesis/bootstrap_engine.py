"""The filter of the thesis: particles move by themselves and are weighed by the frame."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.compiled_bootstrap_filter import CompiledBootstrapFilter
from cable_tracker.cable.engine import Finding, TrackingEngine
from cable_tracker.cable.hypotheses.proposer import CableProposer
from cable_tracker.cable.measure.response_table import ResponseTable
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.estimate import Hypothesis, TrackingStatus
from cable_tracker.cable.model.initialisation import random_states
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.thesis.bootstrap_filter import (
    BootstrapFilter,
    NumpyBootstrapFilter,
    make_observation,
)
from cable_tracker.compilation import uses_compiled_kernels
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.tracking.status import StatusMachine


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
        self._table = table
        self._filter: BootstrapFilter | None = None

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

    def advance(
        self,
        image: WorkingImage,
        dt: float,
        status: StatusMachine,
        motion: MotionAid | None = None,
    ) -> Finding:
        """Look at the next frame, `dt` seconds later; odometry may say how it has moved."""
        if self._filter is None:
            return self.start(self._random(image), image, status)
        if self._is_search_due(status):
            self._filter = self._make_filter(
                Particles.equally_weighted(self._random(image)), image.frame_size[0]
            )
            status = status.searched()
        self._filter.predict(dt, motion)
        return self._look(self._filter, image, status)

    def _random(self, image: WorkingImage) -> FloatArray:
        return random_states(self._parameters, image.frame_size[0], self._rng)

    def _is_search_due(self, status: StatusMachine) -> bool:
        if status.status is TrackingStatus.TRACKING or status.is_confirming:
            return False
        return status.unclaimed_time >= self._parameters.search_time

    def _make_filter(self, particles: Particles, width: int) -> BootstrapFilter:
        parameters = self._parameters
        if parameters.observation == "responses" and uses_compiled_kernels(parameters.kernels):
            return CompiledBootstrapFilter(particles, parameters, width, self._rng)
        observation = make_observation(parameters, self._table)
        return NumpyBootstrapFilter(particles, parameters, observation, width, self._rng)

    def _look(
        self, cable_filter: BootstrapFilter, image: WorkingImage, status: StatusMachine
    ) -> Finding:
        sight = cable_filter.look(image)
        return Finding(
            mean=sight.mean,
            covariance=sight.covariance,
            effective_sample_size=sight.effective_sample_size,
            evidence=sight.evidence,
            rises=sight.evidence >= self._parameters.evidence_to_track,
            holds=sight.evidence >= self._parameters.evidence_to_lose,
            status=status,
            hypotheses=(Hypothesis(1.0, CableState.from_array(sight.mean)),),
        )
