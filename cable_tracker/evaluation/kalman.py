"""A Kalman filter over the four parameters of a cable and their rates.

The constant-velocity filter that detectors of cables are usually followed by (J. Antich and
A. Ortiz (2003), "Underwater Cable Tracking by Visual Feedback"; B. A. A. P. Balasuriya et al.
(1997), "Vision based autonomous underwater vehicle navigation: underwater cable tracking").
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import wrapped_estimate
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE, CableState, pose_units
from cable_tracker.evaluation.metrics.errors import state_errors
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale

FourSigmas: TypeAlias = tuple[float, float, float, float]
"""Standard deviations of d, alpha, w, beta [px at the reference width, deg]."""


def _variances(sigmas: FourSigmas, image_width: int) -> FloatArray:
    """Return the variances for images of a width [px], shape (4,) [px², rad²]."""
    distance, angle, width, skew = sigmas
    in_radians = np.array([distance, np.deg2rad(angle), width, np.deg2rad(skew)])
    return (in_radians * pose_units(pixel_scale(image_width))) ** 2


@dataclass(frozen=True, slots=True)
class KalmanNoise:
    """How a cable moves, and how well it is measured.

    Attributes
    ----------
    measurement : FourSigmas
        Measurement noise of one detection.
    diffusion : FourSigmas
        Process noise of d, alpha, w, beta per frame at 25 frames per second.
    rate_diffusion : FourSigmas
        Process noise of the rates, per frame at 25 frames per second.
    initial_rate : FourSigmas
        The rates of a cable seen for the first time, per frame at 25 frames per second.
    """

    measurement: FourSigmas
    diffusion: FourSigmas = (1.5, 0.3, 1.0, 0.3)
    rate_diffusion: FourSigmas = (2.0, 0.4, 0.6, 0.2)
    initial_rate: FourSigmas = (2.0, 0.5, 0.6, 0.2)


@dataclass(frozen=True, slots=True, eq=False)
class CableKalmanFilter:
    """A Gaussian belief about a cable. Never changed in place.

    Attributes
    ----------
    mean : FloatArray
        Shape (8,), columns of `CableState` [px, rad, per second]; alpha in (-pi/2, pi/2].
    covariance : FloatArray
        Shape (8, 8).
    noise : KalmanNoise
        Process and measurement noise.
    image_width : int
        Width of the frames [px]; lengths of the noise scale with it.
    """

    mean: FloatArray
    covariance: FloatArray
    noise: KalmanNoise
    image_width: int

    @classmethod
    def start(cls, state: CableState, noise: KalmanNoise, image_width: int) -> CableKalmanFilter:
        """Begin with a cable as it was detected once; its rates count for nothing.

        Parameters
        ----------
        state : CableState
            The first measurement [px, rad].
        image_width : int
            Width of the frames [px].
        """
        mean = np.zeros(STATE_SIZE)
        mean[:POSE_SIZE] = state.to_array()[:POSE_SIZE]
        rates = _variances(noise.initial_rate, image_width) * REFERENCE_RATE**2
        variances = np.concatenate((_variances(noise.measurement, image_width), rates))
        return cls(mean, np.diag(variances), noise, image_width)._wrapped()

    @property
    def state(self) -> CableState:
        """The mean as a cable."""
        return CableState.from_array(self.mean)

    def predicted(self, dt: float) -> CableKalmanFilter:
        """Return the belief `dt` seconds later: the rates go on, and uncertainty grows."""
        transition = np.eye(STATE_SIZE)
        transition[:POSE_SIZE, POSE_SIZE:] = dt * np.eye(POSE_SIZE)
        covariance = transition @ self.covariance @ transition.T + self._process_noise(dt)
        return replace(self, mean=transition @ self.mean, covariance=covariance)._wrapped()

    def squared_distance(self, measured: CableState) -> float:
        """Return the squared Mahalanobis distance of a measurement from what is expected."""
        innovation = self._innovation(measured)
        return float(innovation @ np.linalg.solve(self._innovation_covariance(), innovation))

    def updated(self, measured: CableState) -> CableKalmanFilter:
        """Return the belief after a measurement of d, alpha, w, beta."""
        gain = np.linalg.solve(self._innovation_covariance(), self.covariance[:POSE_SIZE]).T
        mean = self.mean + gain @ self._innovation(measured)
        # Joseph's form stays symmetric and positive whatever the rounding.
        keep = np.eye(STATE_SIZE)
        keep[:, :POSE_SIZE] -= gain
        covariance = keep @ self.covariance @ keep.T + gain @ self._measurement_noise() @ gain.T
        return replace(self, mean=mean, covariance=covariance)._wrapped()

    def _innovation(self, measured: CableState) -> FloatArray:
        """Return measured minus expected, with the line written as the expected one is."""
        return state_errors(measured, CableState.from_array(self.mean))

    def _innovation_covariance(self) -> FloatArray:
        return self.covariance[:POSE_SIZE, :POSE_SIZE] + self._measurement_noise()

    def _measurement_noise(self) -> FloatArray:
        return np.diag(_variances(self.noise.measurement, self.image_width))

    def _process_noise(self, dt: float) -> FloatArray:
        """Return what white noise on the parameters and on their rates adds in `dt` seconds."""
        own = _variances(self.noise.diffusion, self.image_width) * REFERENCE_RATE
        rate = _variances(self.noise.rate_diffusion, self.image_width) * REFERENCE_RATE**3
        result = np.zeros((STATE_SIZE, STATE_SIZE))
        result[:POSE_SIZE, :POSE_SIZE] = np.diag(own * dt + rate * dt**3 / 3)
        result[:POSE_SIZE, POSE_SIZE:] = result[POSE_SIZE:, :POSE_SIZE] = np.diag(rate * dt**2 / 2)
        result[POSE_SIZE:, POSE_SIZE:] = np.diag(rate * dt)
        return result

    def _wrapped(self) -> CableKalmanFilter:
        """Write the line with alpha in (-pi/2, pi/2]."""
        mean, covariance = wrapped_estimate(self.mean, self.covariance)
        return replace(self, mean=mean, covariance=covariance)
