"""Messages about a target in pixels, and which of them there are of a frame.

Centre, state, particles and markers are in the image frame: origin at the image centre, x right, y
up [px]. Contours, boxes and marks count from the top left corner of the picture, y down [px], as
boxes of pictures do everywhere, and on the command line.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message, MessageFactory, MessageMakers
from cable_tracker.sequences.messages.frame_report import make_report
from cable_tracker.sequences.messages.line_markers import (
    AMBER,
    GREEN,
    GREY,
    Lines,
    make_line_markers,
    sides_of_polygon,
)
from cable_tracker.sequences.messages.point_cloud import make_point_cloud, read_point_cloud
from cable_tracker.sequences.messages.poses import (
    YAW,
    X,
    Y,
    Z,
    make_stamped_pose,
    make_vector,
    pose_covariance,
)
from cable_tracker.target.model.estimate import TargetEstimate, box_corners
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.model.state import ANGLE
from cable_tracker.tracking.image_frame import from_page

TARGET_STATE_NAMES = ("x", "y", "size", "angle")
TARGET_CLOUD_COLUMNS = ("x", "y", "z", "scale", "angle", "v_x", "v_y", "weight")

MOST_CORNERS = 100_000
"""Largest number of corners of a mark that is read."""


def make_target(factory: MessageFactory, header: Message, estimate: TargetEstimate) -> Message:
    """Pack the centre of a target [px] and its angle as a PoseWithCovarianceStamped.

    The angle is the turn about the line of sight since the start, counter-clockwise. Covariances of
    what a picture does not say are `UNKNOWN_VARIANCE`.
    """
    # x and y are the first two of a target's state, too.
    columns = [X, Y, ANGLE]
    covariance = pose_covariance((X, Y, YAW), estimate.covariance[np.ix_(columns, columns)])
    x, y, angle = (float(value) for value in estimate.state[columns])
    return make_stamped_pose(factory, header, (x, y, 0.0), angle, covariance)


def make_relative_pose(
    factory: MessageFactory, header: Message, position: FloatArray, covariance: FloatArray
) -> Message:
    """Pack where a target is, shape (3,), with its covariance (3, 3) [m].

    How the target itself is turned is not known: no rotation, with `UNKNOWN_VARIANCE`.
    """
    x, y, z = (float(value) for value in position)
    whole = pose_covariance((X, Y, Z), covariance)
    return make_stamped_pose(factory, header, (x, y, z), 0.0, whole)


def make_target_state(
    factory: MessageFactory, header: Message, estimate: TargetEstimate | None
) -> Message:
    """Pack a target as named scalars in a sensor_msgs/JointState.

    ``name`` is [x, y, size, angle], ``position`` their values [px, rad], ``velocity`` their rates
    [per second], ``effort`` one standard deviation of each. The size is the root of the contour's
    area; the filter knows no rates of size and angle: they are 0. Without a claim the last three
    are empty.
    """
    values: FloatArray = np.empty(0)
    rates: FloatArray = np.empty(0)
    sigma: FloatArray = np.empty(0)
    if estimate is not None and estimate.is_claimed:
        x, y, _, angle, x_rate, y_rate = estimate.state
        size = math.sqrt(estimate.area)
        values = np.array([x, y, size, angle])
        rates = np.array([x_rate, y_rate, 0.0, 0.0])
        sigma = estimate.standard_deviations()[:4]
        sigma[2] *= size
    return factory.make(
        node_topics.STATE.type_name,
        header=header,
        name=list(TARGET_STATE_NAMES),
        position=factory.doubles(values),
        velocity=factory.doubles(rates),
        effort=factory.doubles(sigma),
    )


def make_polygon(factory: MessageFactory, header: Message, corners: FloatArray) -> Message:
    """Pack corners (K, 2), px from the top left, as a PolygonStamped."""
    points = [
        factory.make("geometry_msgs/msg/Point32", x=float(x), y=float(y), z=0.0) for x, y in corners
    ]
    polygon = factory.make("geometry_msgs/msg/Polygon", points=points)
    return factory.make("geometry_msgs/msg/PolygonStamped", header=header, polygon=polygon)


def read_start(message: Message) -> TargetStart:
    """Read a mark from a PolygonStamped: two opposite corners of a box, or an outline.

    Raises
    ------
    FrameError
        It has no area, too few or too many corners, or numbers that are not finite.
    """
    count = len(message.polygon.points)
    if count > MOST_CORNERS:
        raise FrameError(f"it has {count} corners; {MOST_CORNERS} are read at most")
    return TargetStart(read_polygon(message))


def read_polygon(message: Message) -> FloatArray:
    """Read the corners of a PolygonStamped, shape (N, 2)."""
    corners = [(float(point.x), float(point.y)) for point in message.polygon.points]
    return np.array(corners, dtype=np.float64).reshape(-1, 2)


def make_bearing(factory: MessageFactory, header: Message, ray: FloatArray) -> Message:
    """Pack a unit vector of the camera optical frame, shape (3,), as a Vector3Stamped."""
    vector = make_vector(factory, ray)
    return factory.make("geometry_msgs/msg/Vector3Stamped", header=header, vector=vector)


def target_report_values(
    estimate: TargetEstimate, ms: float, particle_count: int
) -> dict[str, str]:
    """Return the facts about one frame of a target, as text that loses no digit.

    What there is only with a claim is empty without one: `box` (left, top, right, bottom [px]),
    `area` [px²], `scale`, `corners` of the contour. `particles` are empty before the first target.
    """
    claimed = estimate.is_claimed
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


def make_target_particles(
    factory: MessageFactory, header: Message, particles: Particles
) -> Message:
    """Pack poses as a PointCloud2 of float32.

    Fields x, y [px], z = 0, scale (against the start), angle [rad], v_x, v_y [px/s], weight
    (summing to one).
    """
    x, y, log_scale, angle, x_rate, y_rate = particles.states.T
    points = np.column_stack(
        (x, y, np.zeros(len(x)), np.exp(log_scale), angle, x_rate, y_rate, particles.weights)
    )
    return make_point_cloud(factory, header, TARGET_CLOUD_COLUMNS, points)


def read_target_particles(message: Message) -> FloatArray | None:
    """Read particles packed by `make_target_particles`.

    Returns
    -------
    FloatArray or None
        Columns x, y [px], scale, angle [rad], v_x, v_y [px/s], weight, shape (N, 7); None if there
        are none.
    """
    table = read_point_cloud(message, TARGET_CLOUD_COLUMNS)
    return np.delete(table, TARGET_CLOUD_COLUMNS.index("z"), axis=1) if len(table) else None


def make_target_markers(
    factory: MessageFactory, header: Message, estimate: TargetEstimate
) -> Message:
    """Pack contour, box and image frame as a MarkerArray, 0.01 m to the pixel, y up.

    Without a claim the lines of before are deleted.
    """
    size = estimate.image_size
    drawn = [Lines("image", _sides(box_corners((0.0, 0.0, *size)), size), GREY)]
    if estimate.is_claimed:
        assert estimate.box is not None
        drawn.append(Lines("box", _sides(box_corners(estimate.box), size), GREEN))
        if len(estimate.outline):
            drawn.append(Lines("contour", _sides(estimate.outline, size), AMBER))
    return make_line_markers(factory, header, drawn)


def target_messages(
    factory: MessageFactory,
    header: Message,
    estimate: TargetEstimate,
    particles: Particles | None,
    *,
    ms: float,
    metres: Callable[[], Mapping[str, str]],
) -> MessageMakers:
    """Return makers of the messages about a frame that was used, but for its overlay.

    Parameters
    ----------
    header : Message
        Stamp and frame of the image.
    estimate : TargetEstimate
        Estimate of the frame [px, rad].
    particles : Particles or None
        Particles after the frame, lengths in pixels of it; None before the first target.
    ms : float
        Time the tracker took [ms].
    metres : callable
        Returns what the report says in metres, see `target_facts`; called when the report is made.
    """

    def make_frame_report() -> Message:
        count = particles.count if particles is not None else 0
        values = target_report_values(estimate, ms, count) | dict(metres())
        return make_report(factory, header, estimate.status.value, values)

    makers: MessageMakers = {
        node_topics.STATE: lambda: make_target_state(factory, header, estimate),
        node_topics.TARGET_REPORT: make_frame_report,
    }
    box = estimate.box
    if estimate.is_claimed and box is not None:
        makers[node_topics.TARGET] = lambda: make_target(factory, header, estimate)
        makers[node_topics.BOX] = lambda: make_polygon(factory, header, box_corners(box))
        if len(estimate.outline):
            makers[node_topics.CONTOUR] = lambda: make_polygon(factory, header, estimate.outline)
    if particles is not None:
        makers[node_topics.PARTICLES] = lambda: make_target_particles(factory, header, particles)
    makers[node_topics.MARKERS] = lambda: make_target_markers(factory, header, estimate)
    return makers


def messages_without_target(
    factory: MessageFactory, header: Message, status: str, reason: str
) -> MessageMakers:
    """Return makers of the messages about a frame without an estimate, by status and reason."""
    return {
        node_topics.STATE: lambda: make_target_state(factory, header, None),
        node_topics.TARGET_REPORT: lambda: make_report(factory, header, status, {"event": reason}),
    }


def _sides(corners: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Return the ends of the sides of a polygon (K, 2) that counts from the top left, (2K, 2)."""
    return sides_of_polygon(np.column_stack(from_page(corners[:, 0], corners[:, 1], image_size)))
