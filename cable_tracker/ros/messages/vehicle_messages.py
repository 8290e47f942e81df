"""How the instruments of a simulated vehicle, and its truth, stand in ROS messages."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import Quaternion
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Imu, Range

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.messages import UNKNOWN_VARIANCE, Message
from cable_tracker.simulation.camera import Camera
from cable_tracker.simulation.instruments import (
    LEAST_RANGE,
    MOST_RANGE,
    ImuReading,
    InstrumentErrors,
    OdometryReading,
)
from cable_tracker.simulation.vehicle import Motion

ODOM, BASE = "odom", "base_link"

ALTIMETER_FIELD = math.radians(5.0)
"""Field of view of the altimeter [rad]."""


def make_camera_info(header: Message, camera: Camera) -> Message:
    """Pack the calibration of a simulated camera as CameraInfo."""
    width, height = camera.image_size
    focal, column, row = camera.focal, (width - 1) / 2, (height - 1) / 2
    return CameraInfo(
        header=header,
        width=width,
        height=height,
        distortion_model="plumb_bob",
        d=list(camera.distortion),
        k=[focal, 0.0, column, 0.0, focal, row, 0.0, 0.0, 1.0],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[focal, 0.0, column, 0.0, 0.0, focal, row, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def make_range(header: Message, altitude: float) -> Message:
    """Pack an altitude [m] as Range of a sonar."""
    return Range(
        header=header,
        radiation_type=Range.ULTRASOUND,
        field_of_view=ALTIMETER_FIELD,
        min_range=LEAST_RANGE,
        max_range=MOST_RANGE,
        range=altitude,
    )


def make_imu(header: Message, reading: ImuReading, errors: InstrumentErrors) -> Message:
    """Pack what an imu says as Imu."""
    message = Imu(header=header, orientation=quaternion_of(reading.angles))
    _put(message.angular_velocity, reading.turn)
    _put(message.linear_acceleration, reading.acceleration)
    for covariance, sigma in (
        (message.orientation_covariance, errors.attitude),
        (message.angular_velocity_covariance, errors.turn),
        (message.linear_acceleration_covariance, errors.acceleration),
    ):
        covariance[:] = np.diag([sigma**2] * 3).ravel()
    return message


def make_odometry(header: Message, reading: OdometryReading) -> Message:
    """Pack what odometry says as Odometry."""
    message = Odometry(header=header, child_frame_id=BASE)
    _put(message.pose.pose.position, reading.position)
    message.pose.pose.orientation = quaternion_of(reading.angles)
    message.pose.covariance[:] = reading.pose_covariance.ravel()
    _put(message.twist.twist.linear, reading.twist[:3])
    _put(message.twist.twist.angular, reading.twist[3:])
    message.twist.covariance[:] = reading.twist_covariance.ravel()
    return message


def make_true_odometry(header: Message, motion: Motion) -> Message:
    """Pack where the vehicle is as Odometry, without doubt."""
    nothing = np.zeros((6, 6))
    reading = OdometryReading(motion.position, motion.angles, nothing, motion.twist, nothing)
    return make_odometry(header, reading)


def unknown_covariance() -> FloatArray:
    """Return the covariance (2, 2) of what was not measured."""
    return np.diag([UNKNOWN_VARIANCE, UNKNOWN_VARIANCE])


def quaternion_of(angles: FloatArray) -> Message:
    """Return roll, pitch, yaw [rad] as Quaternion."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles / 2), np.sin(angles / 2)
    return Quaternion(
        x=float(sr * cp * cy - cr * sp * sy),
        y=float(cr * sp * cy + sr * cp * sy),
        z=float(cr * cp * sy - sr * sp * cy),
        w=float(cr * cp * cy + sr * sp * sy),
    )


def yaw_of(quaternion: Message) -> float:
    """Return the yaw of a Quaternion [rad]."""
    q = quaternion
    return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))


def _put(vector: Message, values: FloatArray) -> None:
    vector.x, vector.y, vector.z = (float(value) for value in values)
