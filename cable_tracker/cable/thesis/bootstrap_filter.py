"""The cycle of the thesis' filter: resample if needed, move, weigh, estimate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.kernels import make_likelihood_ratio
from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.response_table import ResponseTable
from cable_tracker.cable.measure.scan_lines import ScanLineObservation
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.movement import CableMovement
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.statistics import cable_mean_and_covariance
from cable_tracker.cable.thesis.evidence import border_evidence
from cable_tracker.cable.thesis.observation import BorderObservation
from cable_tracker.particle_filter.filter import ParticleFilter
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.particle_filter.weights import effective_sample_size


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """What the particles say after one frame.

    Attributes
    ----------
    mean : FloatArray
        The estimate, shape (8,), columns of `StateColumn`; its angle in (-pi/2, pi/2].
    covariance : FloatArray
        Of the particles, shape (8, 8).
    effective_sample_size : float
        N_eff.
    evidence : float
        How clearly the frame shows the weaker border of the estimate.
    """

    mean: FloatArray
    covariance: FloatArray
    effective_sample_size: float
    evidence: float


class BootstrapFilter(Protocol):
    """Particles that move by themselves and are weighed by the frame."""

    @property
    def particles(self) -> Particles:
        """The present belief."""
        ...

    def resample(self, count: int) -> None:
        """Replace the particles by `count` equally weighted ones drawn from them."""
        ...

    def predict(self, dt: float, motion: MotionAid | None = None) -> None:
        """Resample if needed, and move every particle `dt` seconds ahead, as odometry says."""
        ...

    def look(self, image: WorkingImage) -> Sight:
        """Weigh every particle by a frame, and estimate."""
        ...


Observation: TypeAlias = BorderObservation | ScanLineObservation | BorderLikelihoodRatio


def make_observation(parameters: TrackerParameters, table: ResponseTable) -> Observation:
    """Return the observation model that the parameters name."""
    if parameters.observation == "likelihood_ratio":
        return make_likelihood_ratio(parameters, table)
    if parameters.response_sampling == "scan_lines":
        return ScanLineObservation(parameters)
    return BorderObservation(parameters)


class NumpyBootstrapFilter:
    """The filter in plain NumPy, with any observation model.

    Parameters
    ----------
    particles : Particles
        The prior.
    parameters : TrackerParameters
        All of them.
    observation : Observation
        How a frame weighs cables.
    image_width : int
        Width of the frames [px].
    rng : numpy.random.Generator
        The only source of randomness.
    """

    def __init__(
        self,
        particles: Particles,
        parameters: TrackerParameters,
        observation: Observation,
        image_width: int,
        rng: np.random.Generator,
    ) -> None:
        self._observation = observation
        self._movement = CableMovement(parameters, image_width)
        self._filter: ParticleFilter[WorkingImage] = ParticleFilter(
            particles,
            movement=self._movement,
            observation=observation,
            resampling=RESAMPLING_SCHEMES[parameters.resampling],
            resampling_threshold=parameters.resampling_threshold,
            rng=rng,
        )

    @property
    def particles(self) -> Particles:
        """The present belief."""
        return self._filter.particles

    def resample(self, count: int) -> None:
        """Replace the particles by `count` equally weighted ones drawn from them."""
        self._filter.resample(count)

    def predict(self, dt: float, motion: MotionAid | None = None) -> None:
        """Resample if needed, and move every particle `dt` seconds ahead, as odometry says."""
        self._filter.resample_if_degenerate()
        self._movement.aid_by(motion)
        self._filter.predict(dt)

    def look(self, image: WorkingImage) -> Sight:
        """Weigh every particle by a frame, and estimate."""
        self._filter.update(image)
        particles = self._filter.particles
        mean, covariance = cable_mean_and_covariance(particles.states, particles.weights)
        return Sight(
            mean=mean,
            covariance=covariance,
            effective_sample_size=effective_sample_size(particles.log_weights),
            evidence=self._evidence(mean, image),
        )

    def _evidence(self, mean: FloatArray, image: WorkingImage) -> float:
        if isinstance(self._observation, BorderLikelihoodRatio):
            return float(self._observation.measure(mean[None, :], image).weaker_borders.max())
        return border_evidence(self._observation, mean, image)
