"""Metres as ROS messages, and as facts in a frame's report; ROS messages of instruments.

Messages are those of rclpy or of rosbags, of ROS 2 or ROS 1. Facts hold metres to the last bit, or
the reason for their absence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.frames import UNKNOWN_TILT, Attitude, roll_and_pitch
from cable_tracker.metric.odometry.motion import UNKNOWN_TURN
from cable_tracker.metric.targets.relative_state import RelativeState
from cable_tracker.metric.targets.target_metres import TargetMetres
from cable_tracker.metric.withheld import Withheld
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.instruments import MOST_ALTITUDE
from cable_tracker.sequences.messages.factory import Message, MessageFactory, MessageMakers
from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.messages.poses import (
    YAW,
    Y,
    make_stamped_pose,
    pose_covariance,
    unit_quaternion,
)
from cable_tracker.sequences.messages.target import make_bearing, make_relative_pose
from cable_tracker.sequences.tables.estimates import RowMetres

METRES_KEYS = tuple(field.name for field in fields(RowMetres))
"""What is known of a cable in metres, as in the table of estimates."""

NO_METRES_KEY = "no_metres"
"""Why there are no metres."""

BEARING_KEYS = ("bearing_x", "bearing_y", "bearing_z")
"""Unit vector in the camera's optical frame."""

PLACE_KEYS = ("x", "y", "z", "range", "range_sigma")
"""Place in base_link, and range from the camera [m]."""

WHY_NOT_KEY = "why_not"
"""Why there is no position."""

TARGET_METRES_KEYS = (*BEARING_KEYS, *PLACE_KEYS, WHY_NOT_KEY)
"""All keys of a target's metres, in the order of the table in metres."""


def read_camera_info(message: Message, *, is_rectified: bool) -> Calibration:
    """Read a sensor_msgs/CameraInfo as the calibration of the images that belong to it.

    Parameters
    ----------
    message : Message
        Its width and height are those of the whole sensor; the images show the region of interest,
        reduced by the binning.
    is_rectified : bool
        Whether the images are rectified: then the projection matrix counts, and nothing is bent.
    """
    size = (int(message.width), int(message.height))
    if is_rectified:
        whole = Calibration.of_projection(size, _matrix(message, "p"))
    else:
        model = str(message.distortion_model)
        whole = Calibration.of_matrices(size, model, _matrix(message, "k"), _matrix(message, "d"))
    roi = message.roi
    shown = size
    if roi.width and roi.height:
        shown = (int(roi.width), int(roi.height))
        whole = whole.cut((int(roi.x_offset), int(roi.y_offset)), shown)
    binning = (max(int(message.binning_x), 1), max(int(message.binning_y), 1))
    reduced = (shown[0] // binning[0], shown[1] // binning[1])
    return whole.scaled_to(reduced) if min(reduced) > 0 and binning != (1, 1) else whole


def _matrix(message: Message, name: str) -> list[float]:
    """Return a matrix of a CameraInfo; ROS 1 writes its name with a capital."""
    values = getattr(message, name) if hasattr(message, name) else getattr(message, name.upper())
    return [float(value) for value in values]


def read_range(message: Message) -> tuple[float, tuple[float, float]]:
    """Read a sensor_msgs/Range: the distance and its limits [m]; limits that are not set are wide.

    Out of range it is +-inf, as REP 117 has it.
    """
    low, high = float(message.min_range), float(message.max_range)
    low = low if math.isfinite(low) else 0.0
    return float(message.range), (low, high if low < high < math.inf else MOST_ALTITUDE)


def read_attitude(message: Message, least_sigma: float) -> Attitude | None:
    """Read roll and pitch of a sensor_msgs/Imu that is mounted like base_link.

    None if it says that it does not measure them, by a covariance of -1 or beyond `UNKNOWN_TILT`;
    not a number if it has no unit quaternion. `least_sigma` [rad] stands for a covariance that is
    not given, or smaller.
    """
    covariance = [float(value) for value in message.orientation_covariance]
    if covariance[0] == -1.0 or max(covariance[0], covariance[4]) > UNKNOWN_TILT**2:
        return None
    quaternion = unit_quaternion(message.orientation)
    if quaternion is None:
        return Attitude(math.nan, math.nan, least_sigma)
    roll, pitch = roll_and_pitch(*quaternion)
    if not (math.isfinite(covariance[0]) and math.isfinite(covariance[4])):
        return Attitude(math.nan, math.nan, least_sigma)
    sigma = math.sqrt(max(covariance[0], covariance[4], 0.0))
    return Attitude(roll, pitch, max(sigma, least_sigma))


def read_rates_of_turn(message: Message) -> FloatArray | None:
    """Read the rates of turn of a sensor_msgs/Imu that is mounted like base_link, (3,) [rad/s].

    None if it says that it does not measure them, by a covariance of -1 or beyond `UNKNOWN_TURN`.
    """
    covariance = [float(value) for value in message.angular_velocity_covariance]
    if covariance[0] == -1.0 or max(covariance[::4]) > UNKNOWN_TURN**2:
        return None
    return np.array([float(getattr(message.angular_velocity, axis)) for axis in "xyz"])


def read_twist(
    message: Message, least_sigmas: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Read the twist of a nav_msgs/Odometry and its covariance, shapes (6,) and (6, 6).

    It must be in base_link. `least_sigmas` [m/s, rad/s] stand for variances that are not given.
    """
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    twist = np.array([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z], np.float64)
    covariance = np.array(message.twist.covariance, np.float64).reshape(6, 6)
    for k, variance in enumerate(covariance.diagonal().tolist()):
        least = least_sigmas[k // 3] ** 2
        # Written so that NaN counts as not given.
        if not variance >= least:
            # A variance that is raised alone would contradict the correlations beside it.
            covariance[k] = covariance[:, k] = 0.0
            covariance[k, k] = least
    return twist, covariance


def make_cross_track(
    factory: MessageFactory,
    header: Message,
    position: tuple[float, float, float],
    heading: float,
    covariance: FloatArray,
) -> Message:
    """Pack the cable at a position x, y, z [m] and its heading [rad] as PoseWithCovarianceStamped.

    `covariance` (2, 2) is that of y and the heading. What else the pose has room for gets
    `UNKNOWN_VARIANCE`: x is chosen, not measured.
    """
    known = pose_covariance((Y, YAW), covariance)
    return make_stamped_pose(factory, header, position, heading, known)


def cross_track_messages(
    factory: MessageFactory, header: Message, base_frame: str, known: CrossTrack
) -> MessageMakers:
    """Return makers of the messages about a cable in metres: beside the vehicle, and ahead.

    They are of the time of a frame's header, in the vehicle's frame of that name.
    """
    points = {
        node_topics.CROSS_TRACK: (0.0, known.at_foot),
        node_topics.CROSS_TRACK_AHEAD: (known.look_ahead, known.ahead),
    }

    def make(ahead: float, told: Callable[[], tuple[float, FloatArray]]) -> Message:
        offset, covariance = told()
        own_header = make_header(factory, stamp_of(header), base_frame)
        position = (ahead, offset, known.depth)
        return make_cross_track(factory, own_header, position, known.heading, covariance)

    return {topic: partial(make, *point) for topic, point in points.items()}


def relative_messages(
    factory: MessageFactory,
    header: Message,
    base_frame: str,
    known: TargetMetres,
    camera_position: FloatArray,
) -> MessageMakers:
    """Return makers of the messages about a target in metres: bearing and position, if known.

    Parameters
    ----------
    header : Message
        Stamp and frame of the image, in which the bearing is.
    base_frame : str
        Name of the vehicle's frame, in which the position is.
    camera_position : FloatArray
        Position of the camera in that frame, shape (3,) [m].
    """
    ray, state = known.ray, known.relative
    makers: MessageMakers = {}
    if not isinstance(ray, Withheld):
        makers[node_topics.BEARING] = lambda: make_bearing(factory, header, ray)
    if not isinstance(state, Withheld):
        makers[node_topics.RELATIVE_POSE] = lambda: make_relative_pose(
            factory,
            make_header(factory, stamp_of(header), base_frame),
            state.position() + camera_position,
            state.position_covariance(),
        )
    return makers


def row_metres(known: CrossTrack) -> RowMetres:
    """Return a cable's metres for tables and reports."""
    sigma = known.standard_deviations()
    return RowMetres(known.offset, known.heading, float(sigma[0]), float(sigma[2]))


def cable_facts(known: CrossTrack | Withheld) -> dict[str, str]:
    """Return the facts about one frame, those that are known."""
    if isinstance(known, Withheld):
        return {NO_METRES_KEY: str(known)}
    row = row_metres(known)
    return {key: repr(getattr(row, key)) for key in METRES_KEYS}


def read_row_metres(facts: Mapping[str, str]) -> RowMetres | None:
    """Return the metres that the facts of a frame hold; None: they hold none."""
    if not has_metres(facts):
        return None
    return RowMetres(*(float(facts[key]) for key in METRES_KEYS))


def has_metres(facts: Mapping[str, str]) -> bool:
    """Tell whether the facts of a frame hold metres."""
    return METRES_KEYS[0] in facts


def target_facts(metres: TargetMetres, camera_position: FloatArray) -> dict[str, str]:
    """Return the facts about one frame, those that are known.

    Parameters
    ----------
    metres : TargetMetres
        Metric estimate of the target.
    camera_position : FloatArray
        Position of the camera in base_link, shape (3,) [m].
    """
    facts: dict[str, str] = {}
    if not isinstance(metres.ray, Withheld):
        facts |= zip(BEARING_KEYS, (repr(float(value)) for value in metres.ray), strict=True)
    if isinstance(metres.relative, RelativeState):
        state = metres.relative
        numbers = (*(state.position() + camera_position), state.range, state.range_sigma)
        facts |= zip(PLACE_KEYS, (repr(float(value)) for value in numbers), strict=True)
    else:
        facts[WHY_NOT_KEY] = str(metres.relative)
    return facts


def has_bearing(facts: Mapping[str, str]) -> bool:
    """Tell whether the facts of a frame hold a bearing."""
    return BEARING_KEYS[0] in facts


def has_position(facts: Mapping[str, str]) -> bool:
    """Tell whether the facts of a frame hold a position."""
    return PLACE_KEYS[0] in facts
