"""Whether the filters use the vehicle's motion: only while it agrees with picture and cable."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.state import pose_units
from cable_tracker.errors import MetricError, one_line
from cable_tracker.libraries import REFUSALS
from cable_tracker.metric.ground_view import (
    GroundView,
    PlaneMotion,
    homography,
    move_states,
    prediction_covariance,
)
from cable_tracker.metric.odometry.motion import (
    CABLE_DISAGREES,
    FIRST_FRAME,
    NOT_PROVED,
    TEXTURE_DISAGREES,
    Odometry,
    Unaided,
)
from cable_tracker.metric.odometry.sea_bed_texture import SeaBedTexture, TextureGate, TextureMotion
from cable_tracker.metric.withheld import Withheld
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale
from cable_tracker.tracking.succession import is_out_of_order

UNMODELLED = np.array([0.6, np.deg2rad(0.2), 0.5, np.deg2rad(0.1)])
"""Standard deviations of the motion of d, alpha, w, beta in one frame of the reference rate that
the vehicle does not cause: bends of the cable, relief of the bottom, time stamps [px at the
reference width, rad]."""

CHECKED = 2
"""Number of components compared, d and alpha: they show every wrong velocity that does harm."""

UNKNOWN_PER_PIXEL = np.array([1.0, 1.0 / 60.0, 1.0, 1.0 / 60.0])
"""Standard deviations of d, alpha, w, beta for each pixel of the corners' median error: 60 px from
the middle of a turn, 1 px is nearly 1 deg [px, rad per px of the reference width]."""

WINDOW = 12
"""Frames over which predicted and observed motion are compared."""

FEWEST = 5
"""Smallest number of frames for a judgement."""

LARGEST_DRIFT = 4.0
"""Largest drift of predictions over the window [standard deviations]."""

LARGEST_STEP = 2.0
"""Largest error of predictions in half of the frames [standard deviations]."""

AGREEMENT = 0.6
"""Share of both limits below which there is agreement."""

CALM_FRAMES = 15
"""Number of frames in a row with agreement before the filter is aided."""


class MotionAiding:
    """Predicts the motion to each frame from odometry, and decides whether the filter may use it.

    The motion of the sea bed's texture decides. Where there is too little texture, predictions are
    compared with how the filter sees the cable move.

    Parameters
    ----------
    ground_view : callable
        Returns the pose of the camera over the cable's plane in the frame of an estimate, or why it
        is not known.
    odometry : Odometry
        Twists of base_link.
    texture_pause : float
        Least time between two comparisons of the sea bed's texture while it agrees with odometry,
        and between two computations of a prediction's covariance [s]; 0: in every frame. Once the
        texture has ceased to agree, every frame is compared.

    Attributes
    ----------
    unaided : Unaided or None
        Why the last frame was not aided; None if it was, and before the first.
    texture_motion : TextureMotion or None
        How the sea bed moved up to the last frame, beside the prediction; None: not known.
    """

    def __init__(
        self,
        ground_view: Callable[[CableEstimate], GroundView | Withheld],
        odometry: Odometry,
        texture_pause: float = 0.0,
    ) -> None:
        self._texture_pause = round(texture_pause * NANOSECONDS)
        self._texture_due = 0
        self._sigmas: tuple[float, FloatArray] | None = None
        self._ground_view = ground_view
        self._odometry = odometry
        self._gate = AgreementGate()
        self._texture = SeaBedTexture()
        self._texture_gate = TextureGate()
        self.texture_motion: TextureMotion | None = None
        self._before: CableEstimate | None = None
        self._predicted: PlaneMotion | None = None
        self.unaided: Unaided | None = None

    def motion(self, stamp: int, image: Image) -> PlaneMotion | None:
        """Return the motion from the frame before to a frame; None: do not use any.

        Call it once for each frame, before the filter looks at it.

        Parameters
        ----------
        stamp : int
            Time of the frame [ns].
        image : Image
            The frame: grey levels, uint8 or float32 (0..255), shape (H, W).
        """
        if self._before is not None and is_out_of_order(self._before.stamp, stamp):
            # The filter refuses it: the next frame follows the one before.
            return None
        if self._odometry.missing is not None:
            # Nothing to compare the picture with yet.
            self._texture.before = image
            self.unaided = self._odometry.missing if self._before is not None else FIRST_FRAME
            return None
        # Errors end no frame: it is tracked without aid.
        try:
            return self._checked_motion(stamp, image)
        except MetricError as error:
            why = str(error)
        except REFUSALS as refusal:
            why = f"the vehicle's motion cannot be compared with the image: {one_line(refusal)}"
        self.texture_motion = self._predicted = None
        self.unaided = Unaided(why)
        return None

    def pause(self, reason: Unaided) -> None:
        """Leave a frame unaided. The next is not compared with the picture before the pause."""
        self.unaided = reason
        self._texture = SeaBedTexture()
        self.texture_motion = self._predicted = None

    def _checked_motion(self, stamp: int, image: Image) -> PlaneMotion | None:
        """Return the motion by odometry, unless the sea bed or the cable contradicts it."""
        pauses = 0 <= self._texture_due - stamp <= self._texture_pause and self._texture_pause > 0
        prediction = self._predict(stamp, pauses)
        predicted = prediction if isinstance(prediction, PlaneMotion) else None
        motion = self._compare_texture(stamp, image, predicted, pauses)
        self.texture_motion = motion
        if predicted is not None and motion is not None and motion.agrees:
            predicted = _widened(predicted, motion.excess, image.shape[1])
        self._predicted = predicted
        self.unaided = prediction if isinstance(prediction, Unaided) else self._doubt()
        return predicted if self.unaided is None else None

    def _compare_texture(
        self, stamp: int, image: Image, predicted: PlaneMotion | None, pauses: bool
    ) -> TextureMotion | None:
        """Compare a frame's texture with that of the one before, or keep the last result."""
        before = self.texture_motion
        if pauses and predicted is not None and self._texture_gate.verdict and before is not None:
            self._texture.before = image
            return before
        self._texture_due = stamp + self._texture_pause
        motion = self._texture.compare(image, predicted.mapping if predicted is not None else None)
        self._texture_gate.take(motion)
        return motion

    def _doubt(self) -> Unaided | None:
        verdict = self._texture_gate.verdict
        if verdict is None:
            return self._gate.doubt
        return None if verdict else TEXTURE_DISAGREES

    def _predict(self, stamp: int, pauses: bool) -> PlaneMotion | Unaided:
        """Predict the motion; while comparisons pause, with the covariance of the last one."""
        before = self._before
        if before is None:
            return FIRST_FRAME
        change = self._odometry.motion(before.stamp, stamp)
        if isinstance(change, Unaided):
            return change
        view = self._ground_view(before)
        if isinstance(view, Withheld):
            return Unaided(str(view))
        mapping = homography(view, change)
        if pauses and self._sigmas is not None and self._sigmas[0] >= change.seconds:
            return PlaneMotion(mapping, change.seconds, self._sigmas[1])
        covariance = prediction_covariance(before.state.to_array(), view, change)
        frames = change.seconds * REFERENCE_RATE
        floor = UNMODELLED * pose_units(pixel_scale(before.image_size[0])) * np.sqrt(frames)
        sigmas = np.sqrt(np.maximum(np.diag(covariance), 0.0) + floor**2)
        self._sigmas = (change.seconds, sigmas)
        return PlaneMotion(mapping, change.seconds, sigmas)

    def observe(self, estimate: CableEstimate) -> None:
        """Take the filter's answer to that frame: predictions are judged by it."""
        before, self._before = self._before, estimate
        predicted, self._predicted = self._predicted, None
        is_tracked = before is not None and before.is_claimed and estimate.is_claimed
        if before is None or predicted is None or not is_tracked or estimate.event:
            self._gate.interrupt()
            return
        expected = move_states(before.state.to_array()[None, :], predicted.mapping)[0]
        observed = wrap_state(estimate.state.to_array(), float(expected[1]))
        self._gate.compare(
            observed[:CHECKED] - expected[:CHECKED],
            predicted.pose_sigmas[:CHECKED] ** 2,
            np.diag(estimate.covariance)[:CHECKED],
        )


def _widened(motion: PlaneMotion, excess: float, image_width: int) -> PlaneMotion:
    """Count by how much the picture shows a prediction to be off as unknown."""
    more = excess * UNKNOWN_PER_PIXEL * pose_units(pixel_scale(image_width))
    return replace(motion, pose_sigmas=np.hypot(motion.pose_sigmas, more))


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """One frame: what it showed beside what was predicted of d and alpha.

    `residual` (2,), `unknown` (2,) variances of the prediction, `observed` (2,) of the estimates.
    """

    residual: FloatArray
    unknown: FloatArray
    observed: FloatArray


class AgreementGate:
    """Compares predicted with observed motion, and says whether predictions may be used.

    Closed at first: odometry has to prove itself. Two medians are watched, which one frame in which
    the filter jumps does not move. That of the residuals, times their number, is how far the
    predictions have drifted off: a velocity that is always wrong shows in it, also while the filter
    is drawn along. That of their sizes shows a motion that is missed and swings to and fro.
    """

    def __init__(self) -> None:
        self._steps: deque[_Step] = deque(maxlen=WINDOW)
        self._calm = 0
        self._open = False
        self._proved_wrong = False

    @property
    def doubt(self) -> Unaided | None:
        """Why predictions may not be used; None if they may."""
        if self._open:
            return None
        return CABLE_DISAGREES if self._proved_wrong else NOT_PROVED

    def interrupt(self) -> None:
        """Note that a frame could not be compared: drift does not add up across it."""
        self._steps.clear()

    def compare(self, residual: FloatArray, unknown: FloatArray, observed: FloatArray) -> None:
        """Take one frame into account.

        Parameters
        ----------
        residual : FloatArray
            Observed minus predicted d and alpha, shape (2,) [px, rad].
        unknown : FloatArray
            Variances of the prediction, shape (2,).
        observed : FloatArray
            Variances of the estimate, shape (2,).
        """
        self._steps.append(_Step(residual, unknown, observed))
        disagreement = self.disagreement()
        if disagreement is None:
            return
        self._calm = self._calm + 1 if disagreement < AGREEMENT else 0
        if disagreement > 1.0:
            self._open, self._proved_wrong = False, True
        elif not self._open and self._calm >= CALM_FRAMES:
            self._open, self._proved_wrong = True, False

    def disagreement(self) -> float | None:
        """Return by how much the predictions are off, 1 at the limit; None: not known."""
        count = len(self._steps)
        if count < FEWEST:
            return None
        residuals = np.array([step.residual for step in self._steps])
        unknown = np.array([step.unknown for step in self._steps])
        ends = self._steps[0].observed + self._steps[-1].observed
        drift = count * np.abs(np.median(residuals, axis=0)) / np.sqrt(unknown.sum(axis=0) + ends)
        step = np.median(np.abs(residuals) / np.sqrt(unknown), axis=0)
        return float(max(drift.max() / LARGEST_DRIFT, step.max() / LARGEST_STEP))
