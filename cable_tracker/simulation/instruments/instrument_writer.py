"""Writes the readings of a simulated vehicle's instruments, and its true poses, into a bag."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.frames import rotation_in_plane
from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_writer import BagWriter, StorageFormat
from cable_tracker.sequences.bags.frame_messages import write_frame
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.static_transforms import TF_STATIC, TF_TYPE
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.simulation.instruments.instrument_messages import (
    ALTIMETER,
    BASE,
    CAMERA,
    ODOM,
    Fix,
    make_camera_info,
    make_fix,
    make_imu,
    make_odometry,
    make_range,
    make_static_transforms,
    make_true_odometry,
)
from cable_tracker.simulation.instruments.instruments import (
    USUAL_ERRORS,
    ImuReading,
    OdometryReading,
)
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.vehicle import VehicleState
from cable_tracker.stamps import FIRST_STAMP, stamp_at

ORIGIN = (54.25, 7.9)
"""Latitude and longitude of the world's origin [deg]."""

BEARING = math.radians(25.0)
"""Direction of the world's x from east, to the left [rad]."""

DEPTH = 30.0
"""Depth of the sea bed below the ellipsoid [m]."""

FIX_SIGMA = 0.5
"""Standard deviation of an acoustic fix, east and north each [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Tick:
    """State and measurements of the vehicle at one instant; only some have a picture.

    Attributes
    ----------
    seconds : float
        Time since the beginning [s].
    state : VehicleState
        True pose and velocity of the vehicle.
    odometry : OdometryReading
        Reading of odometry.
    imu : ImuReading
        Reading of the imu.
    altitude : float or None
        Reading of the altimeter, with each picture [m].
    fix : FloatArray or None
        Acoustic fix, once a second: x, y in the world, shape (2,) [m].
    frame : Frame or None
        Picture, with the true state of the cable; no truth where none of it is visible.
    """

    seconds: float
    state: VehicleState
    odometry: OdometryReading
    imu: ImuReading
    altitude: float | None = None
    fix: FloatArray | None = None
    frame: Frame | None = None


def to_east_north(places: FloatArray) -> FloatArray:
    """Turn places x, y of the world (N, 2) into metres east and north of its origin."""
    # Places are rows: they are turned by the transposed matrix, which turns back.
    turned: FloatArray = places @ rotation_in_plane(-BEARING)
    return turned


def fix_at(frame: LocalFrame, place: FloatArray, height: float) -> Fix:
    """Return the fix of a place x, y of the world (2,) at a height [m].

    `frame` is that of the world's origin, from which the height counts.
    """
    east, north = to_east_north(place[None, :])[0]
    latitude, longitude, above = frame.to_geodetic(np.array([[east, north, height]]))[0]
    return Fix(float(latitude), float(longitude), float(above), FIX_SIGMA)


def vehicle_text(cable_height: float) -> str:
    """Return the content of `vehicle.yaml`; the height is that of the cable's axis [m]."""
    return (
        "# What no topic of this bag says.\n"
        f"cable_height: {cable_height:.6g}\n"
        "altitude_is_vertical: true\n"
    )


@dataclass(frozen=True, slots=True)
class WrittenDive:
    """Size of the dive that was written.

    Attributes
    ----------
    frames : int
        Pictures in the bag.
    seconds : float
        Length of the dive.
    """

    frames: int
    seconds: float


def write_ticks(
    path: Path,
    ticks: Iterable[Tick],
    camera: Camera,
    cable_height: float,
    *,
    storage: StorageFormat = StorageFormat.MCAP,
    overwrite: bool = False,
) -> WrittenDive:
    """Write a dive into a bag, with a `vehicle.yaml` for what no topic contains.

    Parameters
    ----------
    cable_height : float
        Height of the cable's axis above the bottom [m].
    overwrite : bool
        Replace a bag that lies at the path.

    Raises
    ------
    OutputError
        The bag cannot be written.
    """
    frames, seconds = 0, 0.0
    vehicle = vehicle_text(cable_height).encode()
    with BagWriter(path, storage, overwrite=overwrite, vehicle=vehicle) as bag:
        writer = InstrumentWriter(bag, camera)
        for tick in ticks:
            writer.write(tick)
            seconds = tick.seconds
            frames += tick.frame is not None
    return WrittenDive(frames, seconds)


class InstrumentWriter:
    """Writes the readings of a simulated vehicle's instruments, and its true poses.

    Parameters
    ----------
    bag : BagWriter
        Bag to write to; gets the mounting of camera and altimeter at once.
    """

    def __init__(self, bag: BagWriter, camera: Camera) -> None:
        self._bag = bag
        self._camera = camera
        self._factory = RosbagsMessages()
        self._frame = LocalFrame(*ORIGIN)
        transforms = make_static_transforms(self._factory, FIRST_STAMP, camera.mounting)
        bag.write(TF_STATIC, TF_TYPE, transforms, FIRST_STAMP)

    def write(self, tick: Tick) -> None:
        """Write all messages of an instant."""
        stamp = stamp_at(tick.seconds)
        factory = self._factory
        in_odom = make_header(factory, stamp, ODOM)
        at_base = make_header(factory, stamp, BASE)
        odometry = make_odometry(factory, in_odom, tick.odometry)
        self._write(node_topics.ODOMETRY, odometry, stamp)
        self._write(node_topics.IMU, make_imu(factory, at_base, tick.imu, USUAL_ERRORS), stamp)
        if tick.fix is not None:
            height = float(tick.state.position[2]) - DEPTH
            fix = make_fix(factory, at_base, fix_at(self._frame, tick.fix, height))
            self._write(node_topics.FIX, fix, stamp)
        if tick.altitude is not None:
            self._write_altitude(tick, tick.altitude, stamp)
        if tick.frame is not None:
            write_frame(self._bag, tick.frame)

    def _write_altitude(self, tick: Tick, altitude: float, stamp: int) -> None:
        factory = self._factory
        at_altimeter = make_header(factory, stamp, ALTIMETER)
        at_camera = make_header(factory, stamp, CAMERA)
        in_odom = make_header(factory, stamp, ODOM)
        measured = make_range(factory, at_altimeter, altitude)
        self._write(node_topics.ALTITUDE, measured, stamp)
        calibration = make_camera_info(factory, at_camera, self._camera)
        self._write(node_topics.CAMERA_INFO, calibration, stamp)
        truth = make_true_odometry(factory, in_odom, tick.state)
        self._write(node_topics.TRUE_ODOMETRY, truth, stamp)

    def _write(self, topic: NodeTopic, message: Message, stamp: int) -> None:
        self._bag.write(topic.global_name, topic.type_name, message, stamp)
