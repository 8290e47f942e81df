"""Bearing and range of a followed target, and what turns of the camera do to its picture.

The calibration makes a line of sight of the target's centre; the size it has makes a range of the
size it shows; the vehicle's way between frames makes one of how its bearing changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import MetricError
from cable_tracker.metric.calibration import CameraModel
from cable_tracker.metric.frames import OPTICAL_IN_BODY, Mounting, mounting_of
from cable_tracker.metric.odometry.motion import PoseChange, Unaided
from cable_tracker.metric.targets.relative_state import (
    RelativeState,
    TargetSighting,
    begin_relative_state,
    begin_without_size,
)
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import TargetVehicleParameters
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.estimate import TargetEstimate

UNSURE_RANGE = 0.3
"""Largest standard deviation of a range that is published, as a share of the range."""

LONGEST_GAP = 5.0
"""Time without a frame after which the belief about the range begins anew [s]."""

PIXEL_SIDES = np.array([[0.5, 0.0], [-0.5, 0.0], [0.0, 0.5], [0.0, -0.5]])
"""Middles of a pixel's sides: right, left, upper, lower [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetMetres:
    """Metres of a target in one frame.

    Attributes
    ----------
    ray : FloatArray or Withheld
        Unit vector to its centre in the camera optical frame, shape (3,), or the reason for none.
    relative : RelativeState or Withheld
        Belief about its position from the camera, or the reason for none.
    """

    ray: FloatArray | Withheld
    relative: RelativeState | Withheld


def turn_of_picture(
    camera: CameraModel, mounting: Mounting, rotation: FloatArray
) -> CameraMotion | None:
    """Return the motion of the image by a turn of the vehicle; the same at all distances.

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
    """Return the target's angular size, and bearing and elevation from the optical axis.

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
    parameters : TargetVehicleParameters
        Mounting of the camera, size of the target, and whether motion counts.
    """

    def __init__(self, parameters: TargetVehicleParameters) -> None:
        self._parameters = parameters
        self._mounting = mounting_of(parameters)
        self._state: RelativeState | None = None
        self._stamp = 0

    def configure(self, parameters: TargetVehicleParameters) -> None:
        """Take other parameters; another size or mounting begins anew."""
        size, mounting = self._parameters.target_size, self._mounting
        self._parameters, self._mounting = parameters, mounting_of(parameters)
        if (size, mounting) != (parameters.target_size, self._mounting):
            self._state = None

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
            Motion of the vehicle since the frame before, see `moved_between`.
        """
        self._predict(estimate.stamp, moved)
        if not estimate.is_claimed:
            none = Withheld(Reason.NO_TARGET, "the frame shows none")
            return TargetMetres(none, none)
        if isinstance(camera, Withheld):
            return TargetMetres(camera, camera)
        ray = line_of_sight(estimate, camera)
        if isinstance(ray, Withheld):
            return TargetMetres(ray, ray)
        self._update(sighting_of(estimate, camera, ray))
        return TargetMetres(ray, self._relative_state())

    def _predict(self, stamp: int, moved: PoseChange | Unaided) -> None:
        seconds = (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        if self._state is None:
            return
        if not 0.0 < seconds <= LONGEST_GAP:
            self._state = None
            return
        state = self._state
        if not isinstance(moved, Unaided) and self._parameters.motion_aid:
            turn, arm, axes = moved.rotation, self._mounting.position, state.axes
            way = moved.translation + turn @ arm - arm if moved.has_translation else np.zeros(3)
            state = state.after_motion(axes.T @ turn @ axes, axes.T @ way)
        self._state = state.predicted(seconds)

    def _update(self, seen: TargetSighting) -> None:
        if self._state is not None:
            self._state = self._state.updated(seen)
        elif seen.is_whole and seen.angular_size > 0.0:
            size = self._parameters.target_size
            begun = begin_relative_state(seen, size) if size else begin_without_size(seen)
            self._state = replace(begun, axes=self._mounting.body_rotation)

    def _relative_state(self) -> RelativeState | Withheld:
        state = self._state
        if state is None:
            return Withheld(Reason.RANGE_UNKNOWN, "the target has not been seen as a whole yet")
        if state.range_sigma > UNSURE_RANGE * state.range:
            advice = (
                "" if self._parameters.target_size
                else ": set target_size, or give odometry and move across the line of sight"
            )  # fmt: skip
            share = 100.0 * state.range_sigma / state.range
            return Withheld(Reason.RANGE_UNKNOWN, f"it is unsure by {share:.0f} %{advice}")
        return state
