"""Packs the readings of a simulated vehicle's instruments as messages, of rosbags or of rclpy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.poses import (
    make_quaternion,
    make_uncertain_pose,
    make_vector,
)
from cable_tracker.simulation.instruments.instruments import (
    LEAST_RANGE,
    MOST_RANGE,
    ImuReading,
    InstrumentErrors,
    OdometryReading,
)
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.vehicle import VehicleState
from cable_tracker.tracking.image_frame import image_centre

ODOM, BASE, CAMERA, ALTIMETER = "odom", "base_link", "camera", "altimeter"
"""Frames; "camera" is an optical frame."""

ULTRASOUND = 0
ALTIMETER_FIELD = math.radians(5.0)
"""Field of view of the altimeter [rad]."""

STATUS_FIX, SERVICE_GPS, COVARIANCE_KNOWN = 0, 1, 3


def make_camera_info(factory: MessageFactory, header: Message, camera: Camera) -> Message:
    """Pack the calibration of a simulated camera as CameraInfo."""
    width, height = camera.image_size
    focal, (column, row) = camera.focal, image_centre(camera.image_size)
    return factory.make(
        "sensor_msgs/msg/CameraInfo",
        header=header,
        width=width,
        height=height,
        distortion_model="plumb_bob",
        d=factory.doubles(camera.distortion),
        k=factory.doubles([focal, 0.0, column, 0.0, focal, row, 0.0, 0.0, 1.0]),
        r=factory.doubles([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
        p=factory.doubles([focal, 0.0, column, 0.0, 0.0, focal, row, 0.0, 0.0, 0.0, 1.0, 0.0]),
    )


def make_range(factory: MessageFactory, header: Message, altitude: float) -> Message:
    """Pack an altitude [m] as Range of a sonar."""
    return factory.make(
        "sensor_msgs/msg/Range",
        header=header,
        radiation_type=ULTRASOUND,
        field_of_view=ALTIMETER_FIELD,
        min_range=LEAST_RANGE,
        max_range=MOST_RANGE,
        range=altitude,
    )


def make_imu(
    factory: MessageFactory, header: Message, reading: ImuReading, errors: InstrumentErrors
) -> Message:
    """Pack a reading of the imu as Imu."""

    def spread(sigma: float) -> object:
        return factory.doubles(np.diag([sigma**2] * 3).ravel())

    return factory.make(
        "sensor_msgs/msg/Imu",
        header=header,
        orientation=make_quaternion(factory, *reading.angles),
        orientation_covariance=spread(errors.attitude),
        angular_velocity=make_vector(factory, reading.turn),
        angular_velocity_covariance=spread(errors.turn),
        linear_acceleration=make_vector(factory, reading.acceleration),
        linear_acceleration_covariance=spread(errors.acceleration),
    )


def make_odometry(factory: MessageFactory, header: Message, reading: OdometryReading) -> Message:
    """Pack a reading of odometry as Odometry."""
    x, y, z = (float(value) for value in reading.position)
    orientation = make_quaternion(factory, *reading.angles)
    twist = factory.make(
        "geometry_msgs/msg/Twist",
        linear=make_vector(factory, reading.twist[:3]),
        angular=make_vector(factory, reading.twist[3:]),
    )
    return factory.make(
        "nav_msgs/msg/Odometry",
        header=header,
        child_frame_id=BASE,
        pose=make_uncertain_pose(factory, (x, y, z), orientation, reading.pose_covariance),
        twist=factory.make(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=twist,
            covariance=factory.doubles(reading.twist_covariance.ravel()),
        ),
    )


def make_true_odometry(factory: MessageFactory, header: Message, state: VehicleState) -> Message:
    """Pack the true pose and twist of the vehicle as Odometry, with covariances of zero."""
    nothing = np.zeros((6, 6))
    reading = OdometryReading(state.position, state.angles, nothing, state.twist, nothing)
    return make_odometry(factory, header, reading)


@dataclass(frozen=True, slots=True)
class Fix:
    """A position on the earth, as an acoustic positioning system measures it.

    Attributes
    ----------
    latitude, longitude : float
        WGS 84 [deg].
    height : float
        Above the ellipsoid [m].
    sigma : float
        Standard deviation of east and north, each [m].
    """

    latitude: float
    longitude: float
    height: float
    sigma: float


def make_fix(factory: MessageFactory, header: Message, fix: Fix) -> Message:
    """Pack a fix as NavSatFix."""
    status = factory.make("sensor_msgs/msg/NavSatStatus", status=STATUS_FIX, service=SERVICE_GPS)
    variances = np.diag([fix.sigma**2, fix.sigma**2, fix.sigma**2])
    return factory.make(
        "sensor_msgs/msg/NavSatFix",
        header=header,
        status=status,
        latitude=fix.latitude,
        longitude=fix.longitude,
        altitude=fix.height,
        position_covariance=factory.doubles(variances.ravel()),
        position_covariance_type=COVARIANCE_KNOWN,
    )


def make_static_transforms(factory: MessageFactory, stamp: int, mounting: float) -> Message:
    """Pack the mounting of camera and altimeter, both at the vehicle's origin, as TFMessage.

    `mounting` is the forward tilt of the camera from straight down [rad].
    """
    # Roll, pitch and yaw of the optical frame: x to the right, y down in the image.
    camera = (mounting - math.pi, 0.0, -math.pi / 2)
    transforms = []
    for child, angles in ((CAMERA, camera), (ALTIMETER, (0.0, 0.0, 0.0))):
        transform = factory.make(
            "geometry_msgs/msg/Transform",
            translation=make_vector(factory, np.zeros(3)),
            rotation=make_quaternion(factory, *angles),
        )
        transforms.append(
            factory.make(
                "geometry_msgs/msg/TransformStamped",
                header=make_header(factory, stamp, BASE),
                child_frame_id=child,
                transform=transform,
            )
        )
    return factory.make("tf2_msgs/msg/TFMessage", transforms=transforms)
