"""Trackers that people would use instead: a detector, a Kalman filter, a region of interest.

Every detector of `detection` is followed by the same filter and the same rules, so that a
comparison shows what the detectors are worth. The numbers were chosen on simulated dives of the
seeds 100 to 109 and on nothing else; other seeds are for reporting.

The Kalman filter is that of constant velocity, over the four parameters of a cable and their rates,
that detectors of cables are usually followed by (J. Antich and A. Ortiz (2003), "Underwater Cable
Tracking by Visual Feedback"; B. A. A. P. Balasuriya et al. (1997), "Vision based autonomous
underwater vehicle navigation: underwater cable tracking").
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import wrapped_estimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    STATE_SIZE,
    WIDTH,
    CableState,
    pose_units,
)
from cable_tracker.detection.detector import CableDetector
from cable_tracker.detection.line_pairs import Detection
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.errors import FrameError
from cable_tracker.evaluation.errors import state_errors
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.tracking.succession import FrameMark, check_frame, succession

FourSigmas: TypeAlias = tuple[float, float, float, float]
"""Standard deviations of d, alpha, w, beta [px at the reference width, deg]."""

USUAL_WIDTH = 0.1
"""Share of the image width that w is given as while nothing is known."""

HITS_TO_TRACK = 3
"""Consecutive frames with a fitting detection after which a cable is claimed."""

MISSES_TO_FORGET = 2
"""Consecutive frames without one after which a cable that is not claimed yet is forgotten."""

MISSES_TO_LOSE = 10
"""Consecutive frames without one after which a claimed cable is given up."""

GATE = 18.5
"""Largest squared Mahalanobis distance of a fitting detection: the 99.9 % quantile of chi squared
with four degrees of freedom."""

REGION_SIGMAS = 3.0
"""Half size of the region of interest in standard deviations of the prediction."""

REGION_DISTANCE, REGION_ANGLE, REGION_WIDTH = 20.0, 10.0, 15.0
"""Smallest half sizes of the region of interest [px at the reference width, deg, px at the
reference width]."""

MAXIMUM_GAP = 5.0
"""A longer pause between frames starts the search anew [s]."""


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


class DetectorTracker:
    """Follow the cable that a detector finds, with a Kalman filter and a region of interest.

    Parameters
    ----------
    detector : CableDetector
        Looks at every frame: at the region of interest while a cable is claimed, else everywhere.
    noise : KalmanNoise
        Process noise of the cable, and measurement noise of the detector.
    """

    def __init__(self, detector: CableDetector, noise: KalmanNoise) -> None:
        self._detector = detector
        self._noise = noise
        self._filter: CableKalmanFilter | None = None
        self._prior: CableState | None = None
        self._status = TrackingStatus.INITIALISING
        self._hits = 0
        self._misses = 0
        self._frame: FrameMark | None = None

    def initialise(self, given: GivenState) -> None:
        """Start the next frame from a cable, the middle of what is given.

        It is claimed at once if the detector finds it there.

        Raises
        ------
        FrameError
            The state is not finite.
        """
        if not given.state.is_finite():
            raise FrameError("the initial state must be finite")
        self._prior = given.state

    def process(self, image: Image, stamp: int) -> CableEstimate:
        """Take one frame into account.

        Parameters
        ----------
        image : Image
            Grey levels, uint8 or float32 (0..255), shape (H, W).
        stamp : int
            Time of the frame [ns].

        Returns
        -------
        CableEstimate
            State and covariance of the Kalman filter. The evidence is the score of the detection,
            zero without a fitting one; the effective sample size of a single Gaussian is 1.

        Raises
        ------
        FrameError
            The frame cannot be used, or has the same time as the frame before. Nothing has changed.
        """
        check_frame(image)
        frame = FrameMark((image.shape[1], image.shape[0]), stamp)
        step = succession(self._frame, frame, MAXIMUM_GAP)
        if step.event:
            self._forget(TrackingStatus.INITIALISING)
        self._frame = frame
        self._predict(step.dt, frame.size[0])
        found = self._detect_and_update(image)
        self._count(found is not None)
        return self._estimate(found, step.event)

    def _forget(self, status: TrackingStatus) -> None:
        self._filter, self._status = None, status
        self._hits = self._misses = 0

    def _predict(self, dt: float, image_width: int) -> None:
        if self._prior is not None:
            self._forget(TrackingStatus.INITIALISING)
            self._filter = CableKalmanFilter.start(self._prior, self._noise, image_width)
            # As good as claimed: one hit confirms, and all misses of a claimed cable are allowed.
            self._hits = HITS_TO_TRACK - 1
            self._status = TrackingStatus.TRACKING
            self._prior = None
        elif self._filter is not None:
            self._filter = self._filter.predicted(dt)

    def _detect_and_update(self, image: Image) -> Detection | None:
        """Find the cable in the frame and correct the belief by it."""
        claimed = self._status is TrackingStatus.TRACKING
        region = self._region(self._filter) if claimed and self._filter is not None else None
        detections = self._detector.detect(image, region)
        if self._filter is None:
            return self._begin(detections, image.shape[1])
        # A cable that is not claimed yet has to be the best in the whole image again and again.
        fitting = self._best_fitting(self._filter, detections if claimed else detections[:1])
        if fitting is not None:
            self._filter = self._filter.updated(fitting.state)
        return fitting

    def _begin(self, detections: list[Detection], image_width: int) -> Detection | None:
        if not detections:
            return None
        self._filter = CableKalmanFilter.start(detections[0].state, self._noise, image_width)
        return detections[0]

    def _region(self, belief: CableKalmanFilter) -> SearchRegion:
        scale = pixel_scale(belief.image_width)
        sigmas = REGION_SIGMAS * np.sqrt(np.diag(belief.covariance)[:POSE_SIZE])
        return SearchRegion(
            state=belief.state,
            distance=max(float(sigmas[DISTANCE]), REGION_DISTANCE * scale),
            angle=max(float(sigmas[ANGLE]), math.radians(REGION_ANGLE)),
            width=max(float(sigmas[WIDTH]), REGION_WIDTH * scale),
        )

    def _best_fitting(
        self, belief: CableKalmanFilter, detections: list[Detection]
    ) -> Detection | None:
        """Return the detection inside the gate that is seen best and expected most."""
        best, highest = None, 0.0
        for detection in detections:
            squared = belief.squared_distance(detection.state)
            merit = detection.score * math.exp(-squared / (2 * POSE_SIZE))
            if squared <= GATE and merit > highest:
                best, highest = detection, merit
        return best

    def _count(self, hit: bool) -> None:
        """Count hits and misses, and claim or give up the cable accordingly."""
        self._hits = self._hits + 1 if hit else 0
        self._misses = 0 if hit else self._misses + 1
        if self._status is TrackingStatus.TRACKING:
            if self._misses >= MISSES_TO_LOSE:
                self._forget(TrackingStatus.LOST)
        elif self._hits >= HITS_TO_TRACK:
            self._status = TrackingStatus.TRACKING
        elif self._misses >= MISSES_TO_FORGET:
            self._forget(self._status)

    def _estimate(self, found: Detection | None, event: str) -> CableEstimate:
        assert self._frame is not None
        state = CableState(0.0, 0.0, USUAL_WIDTH * self._frame.size[0])
        covariance: FloatArray = UNKNOWN_VARIANCE * np.eye(STATE_SIZE)
        if self._filter is not None:
            state, covariance = self._filter.state, self._filter.covariance
        return CableEstimate(
            stamp=self._frame.stamp,
            status=self._status,
            state=state,
            covariance=covariance,
            effective_sample_size=1.0,
            evidence=found.score if found is not None else 0.0,
            image_size=self._frame.size,
            event=event,
        )
