"""Write a simulated survey dive into a bag, with everything that a vehicle's bag holds.

Beside the storage file lie `vehicle.yaml`, which says what no topic says, and `truth.json`, which
says how it was: the cable's course, and what stands out along it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.atomic_output import write_bytes
from cable_tracker.metric.frames import rotation_in_plane
from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.metric.recorded import VEHICLE_FILE
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bag_writer import BagWriter
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.messages.cable import make_state
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_image
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.sequences.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.static_transforms import TF_STATIC, TF_TYPE
from cable_tracker.simulation.camera import Camera
from cable_tracker.simulation.instrument_messages import (
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
    optical_rotation,
)
from cable_tracker.simulation.instruments import InstrumentErrors
from cable_tracker.simulation.seen_cable import cable_of_seed, cable_points
from cable_tracker.simulation.survey_dive import (
    FIX_SIGMA,
    SurveyDive,
    SurveyDiveSettings,
    Tick,
)
from cable_tracker.stamps import FIRST_STAMP, NANOSECONDS

ORIGIN = (54.25, 7.9)
"""Latitude and longitude of the world's origin [deg]."""

BEARING = math.radians(25.0)
"""Direction of the world's x from east, to the left [rad]."""

DEPTH = 30.0
"""Depth of the sea bed below the ellipsoid [m]."""

TRUTH = "truth.json"
COURSE_STEP = 0.25
"""Distance between two points of the true course [m]."""


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


def write_survey_bag(
    path: Path,
    settings: SurveyDiveSettings,
    *,
    storage: Literal["sqlite3", "mcap"] = "mcap",
    overwrite: bool = False,
    advance: Callable[[float], None] = lambda way: None,
) -> WrittenDive:
    """Dive, and write everything.

    Parameters
    ----------
    overwrite : bool
        Replace a bag that lies at the path.
    advance : callable
        Told after each picture how far along the course the vehicle is [m].

    Raises
    ------
    OutputError
        The bag cannot be written.
    """
    dive = SurveyDive(settings)
    frames, seconds = 0, 0.0
    with BagWriter(path, storage, overwrite=overwrite) as bag:
        writer = _Writer(bag, dive.camera, dive.errors)
        for tick in dive.ticks():
            writer.write(tick)
            seconds = tick.seconds
            if tick.picture is not None:
                frames += 1
                advance(float(tick.motion.position[0]))
    write_bytes(path / VEHICLE_FILE, vehicle_text(dive.cable_height).encode())
    write_bytes(path / TRUTH, json.dumps(truth_of(settings)).encode())
    return WrittenDive(frames, seconds)


def truth_of(settings: SurveyDiveSettings) -> dict[str, object]:
    """Return what `truth.json` says."""
    along = np.arange(-2.0, settings.length + 4.0, COURSE_STEP)
    course = cable_points(cable_of_seed(settings.cable_seed), along)[0][:, :2]
    return {
        "origin": ORIGIN,
        "bearing": BEARING,
        "along": along.tolist(),
        "world": course.tolist(),
        "east_north": to_east_north(course).tolist(),
        "buried": [[each.start, each.end] for each in settings.buried],
        "crossings": list(settings.crossings),
        "excursions": [[each.start, each.end] for each in settings.excursions],
    }


def vehicle_text(cable_height: float) -> str:
    """Return what `vehicle.yaml` says; the height is that of the cable's axis [m]."""
    return (
        "# What no topic of this bag says.\n"
        f"cable_height: {cable_height:.6g}\n"
        "altitude_is_vertical: true\n"
    )


class InstrumentWriter:
    """Writes what the instruments of a simulated vehicle say, and where it really is.

    Parameters
    ----------
    bag : BagWriter
        Bag to write to; gets the mounting of camera and altimeter at once.
    """

    def __init__(self, bag: BagWriter, camera: Camera, errors: InstrumentErrors) -> None:
        self._bag = bag
        self._camera = camera
        self._errors = errors
        self._factory = RosbagsMessages()
        self._frame = LocalFrame(*ORIGIN)
        rotation = optical_rotation(camera.mounting)
        transforms = make_static_transforms(self._factory, FIRST_STAMP, rotation)
        bag.write(TF_STATIC, TF_TYPE, transforms, FIRST_STAMP)

    def write(self, tick: Tick) -> None:
        """Write everything about an instant but its picture."""
        stamp = FIRST_STAMP + round(tick.seconds * NANOSECONDS)
        factory, errors = self._factory, self._errors
        in_odom = make_header(factory, stamp, ODOM)
        at_base = make_header(factory, stamp, BASE)
        odometry = make_odometry(factory, in_odom, tick.odometry)
        self._write(node_topics.ODOMETRY, odometry, stamp)
        self._write(node_topics.IMU, make_imu(factory, at_base, tick.imu, errors), stamp)
        if tick.fix is not None:
            height = float(tick.motion.position[2]) - DEPTH
            fix = make_fix(factory, at_base, fix_at(self._frame, tick.fix, height))
            self._write(node_topics.FIX, fix, stamp)
        if tick.altitude is not None:
            self._write_altitude(tick, tick.altitude, stamp)

    def _write_altitude(self, tick: Tick, altitude: float, stamp: int) -> None:
        factory = self._factory
        at_altimeter = make_header(factory, stamp, ALTIMETER)
        at_camera = make_header(factory, stamp, CAMERA)
        in_odom = make_header(factory, stamp, ODOM)
        measured = make_range(factory, at_altimeter, altitude)
        self._write(node_topics.ALTITUDE, measured, stamp)
        calibration = make_camera_info(factory, at_camera, self._camera)
        self._write(node_topics.CAMERA_INFO, calibration, stamp)
        truth = make_true_odometry(factory, in_odom, tick.motion)
        self._write(node_topics.TRUE_ODOMETRY, truth, stamp)

    def _write(self, topic: NodeTopic, message: Message, stamp: int) -> None:
        self._bag.write(topic.global_name, topic.type_name, message, stamp)


class _Writer(InstrumentWriter):
    """Writes the pictures of a survey too."""

    def write(self, tick: Tick) -> None:
        super().write(tick)
        if tick.picture is None:
            return
        stamp = FIRST_STAMP + round(tick.seconds * NANOSECONDS)
        factory = self._factory
        at_camera = make_header(factory, stamp, CAMERA)
        self._write(node_topics.GROUND_TRUTH, make_state(factory, at_camera, tick.truth), stamp)
        image = make_image(factory, raw_from_array(tick.picture, "mono8"), at_camera)
        self._write(node_topics.IMAGE, image, stamp)
