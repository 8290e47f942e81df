"""Trackers that people would use instead: a detector, a Kalman filter, a region of interest.

Every detector of `detection` is followed by the same filter and the same rules, so that a
comparison shows what the detectors are worth. The numbers were chosen on simulated dives of the
seeds 100 to 109 and on nothing else; other seeds are for reporting.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    STATE_SIZE,
    WIDTH,
    CableState,
)
from cable_tracker.detection.detector import CableDetector
from cable_tracker.detection.line_pairs import Detection
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.errors import FrameError
from cable_tracker.evaluation.kalman import CableKalmanFilter, KalmanNoise
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.tracking.parameter_table import pixel_scale
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.tracking.succession import FrameMark, check_frame, succession

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
