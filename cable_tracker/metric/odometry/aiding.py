"""Whether the filters use the vehicle's motion: only while it agrees with the picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.state import pose_units
from cable_tracker.errors import MetricError, one_line
from cable_tracker.libraries import REFUSALS
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.metric.odometry.agreement_gate import AgreementGate
from cable_tracker.metric.odometry.homography import (
    PlaneMotion,
    homography,
    move_states,
    prediction_covariance,
)
from cable_tracker.metric.odometry.motion import (
    FIRST_FRAME,
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
