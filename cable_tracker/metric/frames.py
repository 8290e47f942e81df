"""Mounting of the camera on the vehicle, and attitude of the vehicle.

Frames, all right-handed, metres and radians:

* base_link: x forward, y left, z up (REP 103), fixed to the vehicle.
* level: the origin and the heading of base_link, but z vertical. Results are given here: what
  lies one metre to the left is one metre to the left however the vehicle rolls.
* camera body: x along the line of sight, y to the left of the image, z to its top.
* camera optical: z along the line of sight, x to the right of the image, y to its bottom.

Rotations by roll, pitch, yaw are about the fixed axes x, y, z, in this order, as in URDF: a
positive pitch lowers what is in front, a positive roll lowers the right side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import MetricError
from cable_tracker.node_parameter_tables import (
    MOUNTING_PARAMETERS,
    CableVehicleParameters,
    TargetVehicleParameters,
)

UNKNOWN_TILT = math.radians(30.0)
"""An imu that is less sure of roll or pitch does not know them [rad]: instruments say so by a huge
variance as well as by -1, and angles that may be anything have no mean that would be true."""

OPTICAL_IN_BODY: FloatArray = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Rotation from the camera's optical frame to its body frame, shape (3, 3)."""


@dataclass(frozen=True, slots=True)
class Mounting:
    """Pose of the camera on the vehicle.

    Attributes
    ----------
    x, y, z : float
        Position of the camera in base_link [m].
    roll, pitch, yaw : float
        Angles of the camera body in base_link [rad]. A pitch of pi/2 alone looks straight down,
        with the top of the image to the front; 0 looks straight ahead.

    Raises
    ------
    MetricError
        One of them is not finite.
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    pitch: float = math.pi / 2
    yaw: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if not math.isfinite(value):
                raise MetricError(
                    f"the camera's {each.name} is {value}; give its mounting in finite numbers of"
                    " metres and radians"
                )

    @property
    def position(self) -> FloatArray:
        """Position of the camera in base_link, shape (3,) [m]."""
        return np.array([self.x, self.y, self.z])

    @property
    def rotation(self) -> FloatArray:
        """From the camera optical frame to base_link, shape (3, 3), not to be changed."""
        return _rotation_of_camera(self.roll, self.pitch, self.yaw)

    @property
    def body_rotation(self) -> FloatArray:
        """From the camera's own ahead, left, up to base_link, shape (3, 3)."""
        body: FloatArray = self.rotation @ OPTICAL_IN_BODY.T
        return body


@dataclass(frozen=True, slots=True)
class Attitude:
    """How the vehicle hangs.

    Attributes
    ----------
    roll, pitch : float
        Roll and pitch of base_link against the level frame [rad].
    sigma : float
        Standard deviation of each [rad].
    """

    roll: float = 0.0
    pitch: float = 0.0
    sigma: float = 0.0

    @property
    def rotation(self) -> FloatArray:
        """From base_link to the level frame, shape (3, 3)."""
        return rotation_of(np.array([self.roll, self.pitch, 0.0]))

    def is_finite(self) -> bool:
        """Tell whether every number is finite, and sigma not negative."""
        return bool(np.isfinite((self.roll, self.pitch, self.sigma)).all()) and self.sigma >= 0.0


@lru_cache(maxsize=16)
def _rotation_of_camera(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Return the rotation from the optical frame of a camera whose body is turned so [rad]."""
    rotation: FloatArray = rotation_of(np.array([roll, pitch, yaw])) @ OPTICAL_IN_BODY
    rotation.flags.writeable = False
    return rotation


def rotation_of(angles: FloatArray) -> FloatArray:
    """Return the rotation by roll, pitch, yaw (3,) [rad], shape (3, 3)."""
    rotation: FloatArray = rotations_of(angles[None])[0]
    return rotation


def rotations_of(angles: FloatArray) -> FloatArray:
    """Return the rotations by roll, pitch, yaw (N, 3) [rad], shape (N, 3, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles).T, np.sin(angles).T
    rotations = np.empty((len(angles), 3, 3))
    rotations[:, 0, 0], rotations[:, 1, 0], rotations[:, 2, 0] = cy * cp, sy * cp, -sp
    rotations[:, 0, 1] = cy * sp * sr - sy * cr
    rotations[:, 1, 1] = sy * sp * sr + cy * cr
    rotations[:, 2, 1] = cp * sr
    rotations[:, 0, 2] = cy * sp * cr + sy * sr
    rotations[:, 1, 2] = sy * sp * cr - cy * sr
    rotations[:, 2, 2] = cp * cr
    return rotations


def rotation_in_plane(angle: float) -> FloatArray:
    """Return the rotation in the plane by an angle, to the left [rad], shape (2, 2)."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def roll_and_pitch(x: float, y: float, z: float, w: float) -> tuple[float, float]:
    """Return roll and pitch [rad] of a unit quaternion."""
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    return roll, pitch


def mounting_of(parameters: CableVehicleParameters | TargetVehicleParameters) -> Mounting:
    """Return the mounting that the parameters `camera_*` describe."""
    return Mounting(
        parameters.camera_x,
        parameters.camera_y,
        parameters.camera_z,
        math.radians(parameters.camera_roll),
        math.radians(parameters.camera_pitch),
        math.radians(parameters.camera_yaw),
    )


def camera_parameters(rotation: FloatArray, position: FloatArray) -> dict[str, object]:
    """Return the parameters `camera_*` for a camera's optical frame in base_link.

    Parameters
    ----------
    rotation : FloatArray
        From the optical frame to base_link, shape (3, 3).
    position : FloatArray
        Position of the camera in base_link, shape (3,) [m].
    """
    body = rotation @ OPTICAL_IN_BODY.T
    pitch = math.asin(max(-1.0, min(1.0, -float(body[2, 0]))))
    if abs(body[2, 0]) > 1.0 - 1e-9:
        # Straight down or up: only the sum or difference of roll and yaw is known; all is yaw.
        roll, yaw = 0.0, math.atan2(-float(body[0, 1]), float(body[1, 1]))
    else:
        roll = math.atan2(float(body[2, 1]), float(body[2, 2]))
        yaw = math.atan2(float(body[1, 0]), float(body[0, 0]))
    angles = np.degrees([roll, pitch, yaw])
    values = (float(value) for value in (*position, *angles))
    return dict(zip(MOUNTING_PARAMETERS, values, strict=True))
