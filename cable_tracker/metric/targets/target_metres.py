"""Bearing and range of a followed target, and what turns of the camera do to its picture.

The calibration makes a line of sight of the target's centre; the size it has makes a range of the
size it shows; the vehicle's way between frames makes one of how its bearing changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import MetricError
from cable_tracker.metric.calibration import Calibration, CameraModel, camera_for
from cable_tracker.metric.frames import OPTICAL_IN_BODY, Mounting
from cable_tracker.metric.odometry.motion import UNKNOWN_TURN, Odometry, PoseChange, Unaided
from cable_tracker.metric.targets.relative_state import (
    RelativeState,
    TargetSighting,
    begin_relative_state,
    begin_without_size,
)
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.estimate import TargetEstimate

UNSURE_RANGE = 0.3
"""Largest standard deviation of a range that is published, as a share of the range."""

LONGEST_GAP = 5.0
"""Time without a frame after which the belief about the range begins anew [s]."""

TURN_NOT_MEASURED = Unaided(
    "odometry measures no turns (the covariance of its rates is beyond"
    f" {math.degrees(UNKNOWN_TURN):.0f} deg/s); give an imu"
)

TURNS_ALONE = np.diag([UNKNOWN_VARIANCE] * 3 + [0.0] * 3)
"""Covariance of the twist of an instrument that measures turns alone, shape (6, 6)."""

PIXEL_SIDES = np.array([[0.5, 0.0], [-0.5, 0.0], [0.0, 0.5], [0.0, -0.5]])
"""Middles of a pixel's sides: right, left, upper, lower [px]."""


@dataclass(frozen=True, slots=True)
class TargetSettings:
    """Settings that are known beforehand.

    Attributes
    ----------
    mounting : Mounting
        Mounting of the camera on the vehicle.
    target_size : float
        Root of the area that the target shows [m]; 0: not known.
    uses_motion : bool
        Whether odometry and gyroscope are used.
    """

    mounting: Mounting = field(default_factory=lambda: Mounting(pitch=0.0))
    target_size: float = 0.0
    uses_motion: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class TargetMetres:
    """Metres of a target in one frame.

    Attributes
    ----------
    ray : FloatArray or Withheld
        Unit vector to its centre in the camera optical frame, shape (3,), or the reason for none.
    relative : RelativeState or Withheld
        Belief about its place from the camera, or the reason for none.
    """

    ray: FloatArray | Withheld
    relative: RelativeState | Withheld


class VehicleMotion:
    """Calibration and motion of the camera, as far as instruments have told of them."""

    def __init__(self) -> None:
        self._calibration: Calibration | None = None
        self._odometry = Odometry()
        self._gyroscope = Odometry("imu")

    def forget(self) -> None:
        """Forget all measurements; the calibration stays."""
        self._odometry, self._gyroscope = Odometry(), Odometry("imu")

    def take_calibration(self, calibration: Calibration) -> None:
        """Use a calibration from now on."""
        self._calibration = calibration

    def take_twist(self, stamp: int, twist: FloatArray, covariance: FloatArray) -> None:
        """Take a twist of base_link (6,) and its covariance (6, 6) of a time [ns]."""
        self._odometry.add(stamp, twist, covariance)

    def take_turn(self, stamp: int, rates: FloatArray) -> None:
        """Take the rates of turn of base_link (3,) [rad/s] of a time [ns]."""
        self._gyroscope.add(stamp, np.concatenate((np.zeros(3), rates)), TURNS_ALONE)

    def camera(self, image_size: tuple[int, int]) -> CameraModel | Withheld:
        """Return the calibrated camera for images of a size, or why there is none."""
        return camera_for(self._calibration, image_size)

    def between(self, start: int, end: int) -> PoseChange | Unaided:
        """Return how base_link moved between two times [ns], or why that is not known.

        Its turn is known then, its way perhaps not. A turn that odometry does not measure about all
        axes is that of the gyroscope, if there is one.
        """
        moved = self._odometry.motion(start, end)
        if isinstance(moved, PoseChange) and moved.measured_turns == 3:
            return moved
        turned = self._gyroscope.motion(start, end)
        if isinstance(turned, PoseChange):
            if isinstance(moved, PoseChange) and moved.knows_way:
                return self._odometry.turned_by(self._gyroscope, start, end)
            return turned
        if isinstance(moved, PoseChange) and moved.measured_turns:
            # Odometry in a plane: to keep level is nearer to the truth than not to turn.
            return moved
        if self._gyroscope.missing is None:
            return turned
        return TURN_NOT_MEASURED if isinstance(moved, PoseChange) else moved


def turn_of_picture(
    camera: CameraModel, mounting: Mounting, rotation: FloatArray
) -> CameraMotion | None:
    """Return what a turn of the vehicle does to what the camera sees; the same at all distances.

    None of a turn that takes what was seen out of view: see `CameraMotion.keeps_picture`.

    The lens is taken as a pinhole: over the turn from one frame to the next its distortion is
    nearly the same before and after.

    Parameters
    ----------
    camera : CameraModel
        The camera.
    mounting : Mounting
        On the vehicle.
    rotation : FloatArray
        From the later base_link to the earlier one, shape (3, 3).
    """
    matrix = camera.image_matrix
    to_later = mounting.rotation.T @ rotation.T @ mounting.rotation
    mapping = matrix @ to_later @ np.linalg.inv(matrix)
    if not CameraMotion(mapping).keeps_picture(camera.image_size):
        return None
    return CameraMotion(mapping / mapping[2, 2])


def line_of_sight(estimate: TargetEstimate, camera: CameraModel) -> FloatArray | Withheld:
    """Return the unit vector to a target's centre in the optical frame, shape (3,), or why not."""
    try:
        ray = camera.rays(estimate.state[:2])
    except MetricError as error:
        return Withheld(Reason.BAD_CALIBRATION, str(error))
    if not np.isfinite(ray).all():
        return Withheld(
            Reason.BEYOND_LENS, "the lens of this calibration does not reach the target's centre"
        )
    return ray


def solid_angle_of_pixel(camera: CameraModel, point: FloatArray) -> float:
    """Return the solid angle that a pixel covers about a point (2,) of the image frame [sr].

    0 where the lens of the calibration does not reach a pixel's sides.
    """
    right, left, up, down = camera.rays(point + PIXEL_SIDES)
    solid_angle = float(np.linalg.norm(np.cross(right - left, up - down)))
    return solid_angle if math.isfinite(solid_angle) else 0.0


def sighting_of(estimate: TargetEstimate, camera: CameraModel, ray: FloatArray) -> TargetSighting:
    """Return what a frame says of size, bearing and elevation from where the camera looks.

    About the axes of base_link what lies straight below would have no bearing.
    """
    ahead, left, up = OPTICAL_IN_BODY @ ray
    angular_size = math.sqrt(estimate.area * solid_angle_of_pixel(camera, estimate.state[:2]))
    return TargetSighting(
        math.atan2(left, ahead), math.atan2(up, math.hypot(ahead, left)), angular_size,
        estimate.is_whole,
    )  # fmt: skip


class TargetRange:
    """Keeps the belief about where one target is.

    Parameters
    ----------
    settings : TargetSettings
        See there.
    """

    def __init__(self, settings: TargetSettings) -> None:
        self._settings = settings
        self._state: RelativeState | None = None
        self._stamp = 0

    def configure(self, settings: TargetSettings) -> None:
        """Take other settings; another size or mounting begins anew."""
        before = self._settings
        if (settings.target_size, settings.mounting) != (before.target_size, before.mounting):
            self._state = None
        self._settings = settings

    def forget(self) -> None:
        """Begin anew."""
        self._state = None

    def take(
        self,
        estimate: TargetEstimate,
        camera: CameraModel | Withheld,
        moved: PoseChange | Unaided,
    ) -> TargetMetres:
        """Take a frame into account, and say what is known then.

        Parameters
        ----------
        estimate : TargetEstimate
            Estimate of the frame [px].
        camera : CameraModel or Withheld
            Camera that took the frame.
        moved : PoseChange or Unaided
            Motion of the vehicle since the frame before, see `VehicleMotion.between`.
        """
        self._age(estimate.stamp, moved)
        if not estimate.is_claimed:
            none = Withheld(Reason.NO_TARGET, "the frame shows none")
            return TargetMetres(none, none)
        if isinstance(camera, Withheld):
            return TargetMetres(camera, camera)
        ray = line_of_sight(estimate, camera)
        if isinstance(ray, Withheld):
            return TargetMetres(ray, ray)
        self._see(sighting_of(estimate, camera, ray))
        return TargetMetres(ray, self._told())

    def _age(self, stamp: int, moved: PoseChange | Unaided) -> None:
        seconds = (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        if self._state is None:
            return
        if not 0.0 < seconds <= LONGEST_GAP:
            self._state = None
            return
        state = self._state
        if not isinstance(moved, Unaided) and self._settings.uses_motion:
            turn, arm, axes = moved.rotation, self._settings.mounting.position, state.axes
            way = moved.translation + turn @ arm - arm if moved.knows_way else np.zeros(3)
            state = state.seen_from(axes.T @ turn @ axes, axes.T @ way)
        self._state = state.predicted(seconds)

    def _see(self, seen: TargetSighting) -> None:
        if self._state is not None:
            self._state = self._state.updated(seen)
        elif seen.is_whole and seen.angular_size > 0.0:
            size = self._settings.target_size
            begun = begin_relative_state(seen, size) if size else begin_without_size(seen)
            self._state = replace(begun, axes=self._settings.mounting.body_rotation)

    def _told(self) -> RelativeState | Withheld:
        state = self._state
        if state is None:
            return Withheld(Reason.RANGE_UNKNOWN, "the target has not been seen as a whole yet")
        if state.range_sigma > UNSURE_RANGE * state.range:
            advice = (
                "" if self._settings.target_size
                else ": set target_size, or give odometry and move across the line of sight"
            )  # fmt: skip
            share = 100.0 * state.range_sigma / state.range
            return Withheld(Reason.RANGE_UNKNOWN, f"it is unsure by {share:.0f} %{advice}")
        return state
