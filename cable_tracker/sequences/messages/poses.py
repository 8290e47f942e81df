"""Vectors, quaternions and poses with their covariance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.messages.factory import Message, MessageFactory

UNKNOWN_VARIANCE = 1e6
"""Large but finite: what is published for unknown components."""

X, Y, Z, YAW = 0, 1, 2, 5
"""Rows of the covariance (6, 6) of a pose: x, y, z, roll, pitch, yaw."""

QUATERNION_TOLERANCE = 0.1
"""How far from one the length of a quaternion may be that still counts as a rotation."""


def make_vector(factory: MessageFactory, values: FloatArray) -> Message:
    """Pack x, y, z, shape (3,), as a Vector3."""
    x, y, z = (float(value) for value in values)
    return factory.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def make_quaternion(factory: MessageFactory, roll: float, pitch: float, yaw: float) -> Message:
    """Pack a rotation by roll, pitch, yaw [rad] as a Quaternion."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return factory.make(
        "geometry_msgs/msg/Quaternion",
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )


def make_pose_at_origin(factory: MessageFactory) -> Message:
    """Pack no translation and no rotation as a Pose."""
    # Said in full: rosbags knows no default values, and its zero quaternion is no rotation.
    return factory.make(
        "geometry_msgs/msg/Pose",
        position=factory.make("geometry_msgs/msg/Point", x=0.0, y=0.0, z=0.0),
        orientation=make_quaternion(factory, 0.0, 0.0, 0.0),
    )


def make_uncertain_pose(
    factory: MessageFactory,
    position: tuple[float, float, float],
    orientation: Message,
    covariance: FloatArray,
) -> Message:
    """Pack a position x, y, z, a Quaternion and their covariance (6, 6) as PoseWithCovariance."""
    x, y, z = position
    return factory.make(
        "geometry_msgs/msg/PoseWithCovariance",
        pose=factory.make(
            "geometry_msgs/msg/Pose",
            position=factory.make("geometry_msgs/msg/Point", x=x, y=y, z=z),
            orientation=orientation,
        ),
        # A copy: rclpy keeps an array as it is.
        covariance=np.array(covariance, dtype=np.float64).reshape(-1),
    )


def make_stamped_pose(
    factory: MessageFactory,
    header: Message,
    position: tuple[float, float, float],
    yaw: float,
    covariance: FloatArray,
) -> Message:
    """Pack a position x, y, z, a rotation about z and their covariance.

    Parameters
    ----------
    position : (float, float, float)
        In the unit of the frame, [px] or [m].
    yaw : float
        Rotation about z [rad].
    covariance : FloatArray
        Covariance of x, y, z, roll, pitch, yaw, shape (6, 6) [m, rad].

    Returns
    -------
    Message
        A PoseWithCovarianceStamped.
    """
    orientation = make_quaternion(factory, 0.0, 0.0, yaw)
    return factory.make(
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        header=header,
        pose=make_uncertain_pose(factory, position, orientation, covariance),
    )


def pose_covariance(rows: Sequence[int], known: FloatArray) -> FloatArray:
    """Return the covariance of a pose of which only some components are known.

    Parameters
    ----------
    rows : sequence of int
        The K components that are known, of `X`, `Y`, `Z` and `YAW`.
    known : FloatArray
        Their covariance, shape (K, K).

    Returns
    -------
    FloatArray
        Of x, y, z, roll, pitch, yaw, symmetric, shape (6, 6); what is not known has
        `UNKNOWN_VARIANCE` and is uncorrelated.
    """
    covariance = np.diag(np.full(6, UNKNOWN_VARIANCE))
    covariance[np.ix_(rows, rows)] = (known + known.T) / 2
    return covariance


def unit_quaternion(quaternion: Message) -> tuple[float, float, float, float] | None:
    """Return x, y, z, w of a Quaternion, scaled to length one; None: it is no rotation."""
    x, y, z, w = (float(getattr(quaternion, axis)) for axis in "xyzw")
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    # Written so that NaN counts as no rotation.
    if not abs(norm - 1.0) <= QUATERNION_TOLERANCE:
        return None
    return x / norm, y / norm, z / norm, w / norm


def yaw_of(quaternion: Message) -> float:
    """Return the yaw of a Quaternion [rad], whatever its length."""
    q = quaternion
    return math.atan2(2 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z)
