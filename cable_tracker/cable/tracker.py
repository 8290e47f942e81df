"""The cable tracker: a frame and its time in, an estimate out."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.estimate import CableEstimate, TrackingStatus
from cable_tracker.cable.evidence import border_evidence
from cable_tracker.cable.initialisation import StatePrior, random_states, states_from_prior
from cable_tracker.cable.movement import CableMovement
from cable_tracker.cable.observation import BorderObservation
from cable_tracker.cable.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.cable.state import CableState, StateColumn
from cable_tracker.cable.statistics import cable_mean_and_covariance
from cable_tracker.cable.status import StatusMachine
from cable_tracker.cable.succession import FrameMark, succession
from cable_tracker.cable.working_image import WorkingImage, check_frame, make_working_image
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.filter import ParticleFilter
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.particle_filter.weights import effective_sample_size


class CableTracker:
    """Track one cable through a sequence of frames.

    Parameters
    ----------
    parameters : TrackerParameters
        The same parameters, frames and times give the same estimates, bit for bit.

    Examples
    --------
    >>> import numpy as np
    >>> tracker = CableTracker(TrackerParameters(seed=1))
    >>> estimate = tracker.process(np.zeros((240, 320), np.uint8), stamp=1_000_000_000)
    >>> estimate.status.value
    'INITIALISING'
    """

    def __init__(self, parameters: TrackerParameters | None = None) -> None:
        self._parameters = parameters if parameters is not None else TrackerParameters()
        self._rng = np.random.default_rng(self._parameters.seed)
        self._observation = BorderObservation(self._parameters)
        self._filter: ParticleFilter[WorkingImage] | None = None
        self._prior: StatePrior | None = None
        self._status = StatusMachine()
        self._frame: FrameMark | None = None

    @property
    def parameters(self) -> TrackerParameters:
        """The parameters in force."""
        return self._parameters

    @property
    def particles(self) -> Particles | None:
        """The present belief; None before the first frame."""
        return self._filter.particles if self._filter else None

    def configure(self, parameters: TrackerParameters) -> None:
        """Take other parameters from now on, and keep the belief.

        A changed number of particles draws that many from the present ones. A changed seed waits
        for the next reset.
        """
        self._parameters = parameters
        self._observation = BorderObservation(parameters)
        if self._filter is not None:
            self._filter = self._make_filter(self._filter.particles)
            if self._filter.particles.count != parameters.particle_count:
                self._filter.resample(parameters.particle_count)

    def reset(self) -> None:
        """Forget everything; the next frame is like the first, with the same random numbers."""
        self._rng = np.random.default_rng(self._parameters.seed)
        self._filter = None
        self._prior = None
        self._status = StatusMachine()
        self._frame = None

    def initialise(self, prior: StatePrior) -> None:
        """Start the next frame from a given belief instead of the present one.

        The cable is claimed with that frame already if its borders are there.

        Raises
        ------
        FrameError
            The state is not finite, or a sigma is negative.
        """
        if not prior.state.is_finite() or bool(np.any(prior.sigma < 0.0)):
            raise FrameError("the initial state must be finite, and its sigmas not negative")
        self._prior = prior

    def process(self, image: Image, stamp: int) -> CableEstimate:
        """Take one frame into account.

        Parameters
        ----------
        image : Image
            Grey levels, uint8 or float32 (0..255), shape (H, W).
        stamp : int
            Time of the frame [ns].

        Raises
        ------
        FrameError
            The frame cannot be used, or has the same time as the frame before. Nothing has changed.
        """
        check_frame(image)
        frame = FrameMark((image.shape[1], image.shape[0]), stamp)
        step = succession(self._frame, frame, self._parameters.maximum_gap)
        if step.event:
            self._filter = None
            self._status = StatusMachine()
        self._frame = frame
        working_image = make_working_image(image, self._parameters.working_width)
        return self._advance(working_image, step.dt, step.event)

    def _advance(self, image: WorkingImage, dt: float, event: str) -> CableEstimate:
        if self._prior is not None:
            self._start_from_prior(self._prior)
        elif self._filter is None:
            self._start_from_random()
        else:
            self._search_anew_if_due()
            assert self._filter is not None
            self._filter.resample_if_degenerate()
            self._filter.predict(dt)
        assert self._filter is not None
        self._filter.update(image)
        return self._estimate(image, dt, event)

    def _start_from_prior(self, prior: StatePrior) -> None:
        assert self._frame is not None
        states = states_from_prior(prior, self._parameters, self._frame.size[0], self._rng)
        self._filter = self._make_filter(Particles.equally_weighted(states))
        self._status = StatusMachine().expecting()
        self._prior = None

    def _start_from_random(self) -> None:
        assert self._frame is not None
        states = random_states(self._parameters, self._frame.size[0], self._rng)
        self._filter = self._make_filter(Particles.equally_weighted(states))

    def _search_anew_if_due(self) -> None:
        if self._status.status is TrackingStatus.TRACKING or self._status.is_confirming:
            return
        if self._status.unclaimed_time >= self._parameters.search_time:
            self._start_from_random()
            self._status = self._status.searched()

    def _make_filter(self, particles: Particles) -> ParticleFilter[WorkingImage]:
        assert self._frame is not None
        return ParticleFilter(
            particles,
            movement=CableMovement(self._parameters, self._frame.size[0]),
            observation=self._observation,
            resampling=RESAMPLING_SCHEMES[self._parameters.resampling],
            resampling_threshold=self._parameters.resampling_threshold,
            rng=self._rng,
        )

    def _estimate(self, image: WorkingImage, dt: float, event: str) -> CableEstimate:
        assert self._filter is not None and self._frame is not None
        particles = self._filter.particles
        mean, covariance = cable_mean_and_covariance(particles.states, particles.weights)
        evidence = border_evidence(self._observation, mean, image)
        converged = self._has_converged(covariance, image.frame_size[0])
        self._status = self._status.after(evidence, converged, dt, self._parameters)
        return CableEstimate(
            stamp=self._frame.stamp,
            status=self._status.status,
            state=CableState.from_array(mean),
            covariance=covariance,
            effective_sample_size=effective_sample_size(particles.log_weights),
            evidence=evidence,
            image_size=image.frame_size,
            event=event,
        )

    def _has_converged(self, covariance: FloatArray, image_width: int) -> bool:
        scale = image_width / REFERENCE_WIDTH
        sigma_distance = math.sqrt(covariance[StateColumn.DISTANCE, StateColumn.DISTANCE])
        sigma_angle = math.sqrt(covariance[StateColumn.ANGLE, StateColumn.ANGLE])
        return (
            sigma_distance <= self._parameters.converged_distance * scale
            and sigma_angle <= math.radians(self._parameters.converged_angle)
        )
