"""How what is known of a target stands in ROS messages, of rclpy or of rosbags.

Centre, state and particles are in the image frame: origin at the image centre, x right, y up [px].
Contours, boxes and marks count from the top left corner of the picture, y down [px], as boxes of
pictures do everywhere, and on the command line.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.messages import (
    MARKER_ADD,
    MARKER_DELETE_ALL,
    MARKER_LINE_LIST,
    METRES_PER_PIXEL,
    UNKNOWN_VARIANCE,
    Message,
    MessageFactory,
    point_cloud,
)
from cable_tracker.target.model.estimate import Box, TargetEstimate
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.model.state import PoseColumn
from cable_tracker.tracking.status import TrackingStatus

TARGET_STATE_NAMES = ("x", "y", "size", "angle")

TARGET_CLOUD_COLUMNS = ("x", "y", "z", "scale", "angle", "v_x", "v_y", "weight")

MOST_CORNERS = 100_000
"""Largest number of corners of a mark that is read."""


def is_claimed(estimate: TargetEstimate | None) -> bool:
    """Tell whether an estimate claims a target, with an outline."""
    return (
        estimate is not None
        and estimate.status is TrackingStatus.TRACKING
        and estimate.box is not None
    )


def make_target(factory: MessageFactory, header: Message, estimate: TargetEstimate) -> Message:
    """Pack the centre of a target [px] and its angle as a PoseWithCovarianceStamped.

    The angle is the turn about the line of sight since the start, counter-clockwise. Covariances of
    what a picture does not say are `UNKNOWN_VARIANCE`.
    """
    state = estimate.state
    rows = [0, 1, 5]
    columns = [PoseColumn.X, PoseColumn.Y, PoseColumn.ANGLE]
    covariance = np.diag(np.full(6, UNKNOWN_VARIANCE))
    known = estimate.covariance[np.ix_(columns, columns)]
    covariance[np.ix_(rows, rows)] = (known + known.T) / 2
    place = (float(state[PoseColumn.X]), float(state[PoseColumn.Y]), 0.0)
    return _pose_stamped(factory, header, place, float(state[PoseColumn.ANGLE]), covariance)


def make_relative_pose(
    factory: MessageFactory, header: Message, place: FloatArray, covariance: FloatArray
) -> Message:
    """Pack where a target is, shape (3,), with its covariance (3, 3) [m].

    How the target itself is turned is not known: no rotation, with `UNKNOWN_VARIANCE`.
    """
    whole = np.diag(np.full(6, UNKNOWN_VARIANCE))
    whole[:3, :3] = (covariance + covariance.T) / 2
    x, y, z = (float(value) for value in place)
    return _pose_stamped(factory, header, (x, y, z), 0.0, whole)


def _pose_stamped(
    factory: MessageFactory,
    header: Message,
    place: tuple[float, float, float],
    yaw: float,
    covariance: FloatArray,
) -> Message:
    x, y, z = place
    turn = factory.make(
        "geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)
    )
    pose = factory.make(
        "geometry_msgs/msg/Pose",
        position=factory.make("geometry_msgs/msg/Point", x=x, y=y, z=z),
        orientation=turn,
    )
    with_covariance = factory.make(
        "geometry_msgs/msg/PoseWithCovariance",
        pose=pose,
        covariance=factory.doubles(covariance.reshape(-1)),
    )
    return factory.make(
        "geometry_msgs/msg/PoseWithCovarianceStamped", header=header, pose=with_covariance
    )


def make_target_state(
    factory: MessageFactory, header: Message, estimate: TargetEstimate | None
) -> Message:
    """Pack a target as named scalars in a sensor_msgs/JointState.

    ``name`` is [x, y, size, angle], ``position`` their values [px, rad], ``velocity`` their rates
    [per second], ``effort`` one standard deviation of each. The size is the root of the contour's
    area; the filter knows no rates of size and angle: they are 0. Without a claim the last three
    are empty.
    """
    position: FloatArray = np.empty(0)
    velocity: FloatArray = np.empty(0)
    sigma: FloatArray = np.empty(0)
    if estimate is not None and is_claimed(estimate):
        state, deviations = estimate.state, estimate.standard_deviations()
        size = math.sqrt(estimate.area)
        position = np.array([state[0], state[1], size, state[PoseColumn.ANGLE]])
        velocity = np.array([state[PoseColumn.X_RATE], state[PoseColumn.Y_RATE], 0.0, 0.0])
        sigma = deviations[:4].copy()
        sigma[2] *= size
    return factory.make(
        "sensor_msgs/msg/JointState",
        header=header,
        name=list(TARGET_STATE_NAMES),
        position=factory.doubles(position),
        velocity=factory.doubles(velocity),
        effort=factory.doubles(sigma),
    )


def make_polygon(factory: MessageFactory, header: Message, corners: FloatArray) -> Message:
    """Pack corners (K, 2), px from the top left, as a PolygonStamped."""
    points = [
        factory.make("geometry_msgs/msg/Point32", x=float(x), y=float(y), z=0.0) for x, y in corners
    ]
    polygon = factory.make("geometry_msgs/msg/Polygon", points=points)
    return factory.make("geometry_msgs/msg/PolygonStamped", header=header, polygon=polygon)


def box_corners(box: Box) -> FloatArray:
    """Return the corners of a box, clockwise from the top left, shape (4, 2)."""
    left, top, right, bottom = box
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])


def read_start(message: Message) -> TargetStart:
    """Read a mark from a PolygonStamped: two opposite corners of a box, or an outline.

    Raises
    ------
    FrameError
        It has no area, too few or too many corners, or numbers that are not finite.
    """
    points = message.polygon.points
    if len(points) > MOST_CORNERS:
        raise FrameError(f"it has {len(points)} corners; {MOST_CORNERS} are read at most")
    corners = np.array([(float(point.x), float(point.y)) for point in points], dtype=np.float64)
    return TargetStart(corners.reshape(-1, 2))


def make_bearing(factory: MessageFactory, header: Message, ray: FloatArray) -> Message:
    """Pack a unit vector of the camera optical frame, shape (3,), as a Vector3Stamped."""
    x, y, z = (float(value) for value in ray)
    vector = factory.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)
    return factory.make("geometry_msgs/msg/Vector3Stamped", header=header, vector=vector)


def make_target_particles(
    factory: MessageFactory, header: Message, particles: Particles
) -> Message:
    """Pack poses as a PointCloud2 of float32.

    Fields x, y [px], z = 0, scale (against the start), angle [rad], v_x, v_y [px/s], weight
    (summing to one).
    """
    states = particles.states
    points = np.column_stack(
        (
            states[:, PoseColumn.X], states[:, PoseColumn.Y], np.zeros(len(states)),
            np.exp(states[:, PoseColumn.LOG_SCALE]), states[:, PoseColumn.ANGLE],
            states[:, PoseColumn.X_RATE], states[:, PoseColumn.Y_RATE], particles.weights,
        )
    )  # fmt: skip
    return point_cloud(factory, header, TARGET_CLOUD_COLUMNS, points)


def read_target_particles(message: Message) -> FloatArray | None:
    """Read particles packed by `make_target_particles`.

    Returns
    -------
    FloatArray or None
        Columns x, y [px], scale, angle [rad], v_x, v_y [px/s], weight, shape (N, 7); None if there
        are none.
    """
    points = np.frombuffer(memoryview(message.data).cast("B"), dtype="<f4")
    table = points.reshape(-1, len(TARGET_CLOUD_COLUMNS)).astype(np.float64)
    return np.delete(table, TARGET_CLOUD_COLUMNS.index("z"), axis=1) if len(table) else None


def make_target_markers(
    factory: MessageFactory,
    header: Message,
    estimate: TargetEstimate | None,
    image_size: tuple[int, int],
) -> Message:
    """Pack contour, box and image frame as a MarkerArray, 0.01 m to the pixel, y up.

    Without a claim the lines of before are deleted.
    """
    width, height = image_size
    frame = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    lines = [(0, "image", frame, (0.5, 0.5, 0.5))]
    if estimate is not None and is_claimed(estimate):
        assert estimate.box is not None
        lines.append((1, "box", box_corners(estimate.box), (0.0, 0.75, 0.375)))
        if len(estimate.outline):
            lines.append((2, "contour", estimate.outline, (1.0, 0.75, 0.0)))
    delete = factory.make(
        "visualization_msgs/msg/Marker",
        header=header,
        action=MARKER_DELETE_ALL,
        pose=_unmoved(factory),
    )
    markers = [delete]
    for number, name, corners, (red, green, blue) in lines:
        markers.append(
            factory.make(
                "visualization_msgs/msg/Marker",
                header=header,
                ns=name,
                id=number,
                type=MARKER_LINE_LIST,
                action=MARKER_ADD,
                pose=_unmoved(factory),
                scale=factory.make(
                    "geometry_msgs/msg/Vector3", x=2 * METRES_PER_PIXEL, y=0.0, z=0.0
                ),
                color=factory.make("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0),
                points=_segments(factory, corners, image_size),
            )
        )
    return factory.make("visualization_msgs/msg/MarkerArray", markers=markers)


def _segments(
    factory: MessageFactory, corners: FloatArray, image_size: tuple[int, int]
) -> list[Message]:
    """Return the ends of the sides of a polygon (K, 2) that counts from the top left."""
    places = np.column_stack((corners[:, 0] - image_size[0] / 2, image_size[1] / 2 - corners[:, 1]))
    ends = np.stack((places, np.roll(places, -1, axis=0)), axis=1).reshape(-1, 2)
    return [
        factory.make(
            "geometry_msgs/msg/Point",
            x=float(x) * METRES_PER_PIXEL,
            y=float(y) * METRES_PER_PIXEL,
            z=0.0,
        )
        for x, y in ends
    ]


def _unmoved(factory: MessageFactory) -> Message:
    # Said in full: rosbags knows no default values, and its zero quaternion is no rotation.
    orientation = factory.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    return factory.make("geometry_msgs/msg/Pose", orientation=orientation)


def target_report_values(
    estimate: TargetEstimate, ms: float, particle_count: int
) -> dict[str, str]:
    """Return the facts about one frame of a target, as text that loses no digit.

    What there is only with a claim is empty without one: `box` (left, top, right, bottom [px]),
    `area` [px²], `scale`, `corners` of the contour. `particles` are empty before the first target.
    """
    claimed = is_claimed(estimate)
    box = " ".join(repr(float(side)) for side in estimate.box or ()) if claimed else ""
    return {
        "n_eff": repr(float(estimate.effective_sample_size)),
        "ms": repr(ms),
        "presence": repr(float(estimate.presence)),
        "scale": repr(estimate.scale) if claimed else "",
        "area": repr(float(estimate.area)) if claimed else "",
        "box": box,
        "corners": str(len(estimate.outline)) if claimed and len(estimate.outline) else "",
        "particles": str(particle_count) if particle_count else "",
        "score": repr(float(estimate.score)),
        "event": estimate.event,
    }
