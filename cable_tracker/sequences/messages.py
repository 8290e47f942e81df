"""How images, estimates and ground truth are packed into ROS messages, and read back.

The one place that knows the fields. It serves the nodes, whose messages are rclpy's, and the
recorder without ROS, whose messages are rosbags': a `MessageFactory` makes either kind. A message
package of our own would replace this module and nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import foot_point, project_borders, segment_inside
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import STATE_SIZE, STATE_SYMBOLS, CableState, StateColumn
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.stamps import NANOSECONDS

Message: TypeAlias = Any
"""A message object of rclpy or of rosbags; neither has static types."""

UNKNOWN_VARIANCE = 1e6
"""Large but finite: what is published for unknown components."""

STATE_NAMES = STATE_SYMBOLS[:4]
METRES_PER_PIXEL = 0.01
"""Scale of the markers, so that an image is a few metres wide in rviz."""

POINT_FIELD_FLOAT32 = 7
MARKER_LINE_LIST, MARKER_ADD, MARKER_DELETE_ALL = 5, 0, 3

CLOUD_COLUMNS = ("x", "y", "z", *STATE_SYMBOLS, "weight")


class MessageFactory(Protocol):
    """Makes messages of one ROS implementation."""

    def make(self, type_name: str, /, **fields: object) -> Message:
        """Return a message of a type such as ``std_msgs/msg/Header``; other fields are default."""
        ...

    def doubles(self, values: Sequence[float] | FloatArray) -> object:
        """Return the value of a field ``float64[]``."""
        ...

    def octets(self, data: bytes | memoryview) -> object:
        """Return the value of a field ``uint8[]``."""
        ...

    def octet(self, value: int) -> object:
        """Return the value of a field ``byte``."""
        ...


def make_time(factory: MessageFactory, stamp: int) -> Message:
    """Pack nanoseconds."""
    return factory.make(
        "builtin_interfaces/msg/Time", sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS
    )


def make_header(factory: MessageFactory, stamp: int, frame_id: str) -> Message:
    """Pack a stamp [ns] and a frame."""
    return factory.make("std_msgs/msg/Header", stamp=make_time(factory, stamp), frame_id=frame_id)


def stamp_of(header: Message) -> int:
    """Return a header's stamp [ns]."""
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)


def make_image(factory: MessageFactory, image: RawImage, header: Message) -> Message:
    """Pack uncompressed pixels as sensor_msgs/Image."""
    return factory.make(
        "sensor_msgs/msg/Image",
        header=header,
        height=image.height,
        width=image.width,
        encoding=image.encoding,
        is_bigendian=int(image.is_bigendian),
        step=image.step,
        data=factory.octets(image.data),
    )


def make_compressed_image(
    factory: MessageFactory, image: CompressedImage, header: Message
) -> Message:
    """Pack a JPEG or PNG file as sensor_msgs/CompressedImage."""
    return factory.make(
        "sensor_msgs/msg/CompressedImage",
        header=header,
        format=image.format,
        data=factory.octets(image.data),
    )


def read_image(message: Message) -> RawImage:
    """Read a sensor_msgs/Image without copying its pixels."""
    return RawImage(
        encoding=str(message.encoding),
        height=int(message.height),
        width=int(message.width),
        step=int(message.step),
        is_bigendian=bool(message.is_bigendian),
        data=memoryview(message.data).cast("B"),
    )


def read_compressed_image(message: Message) -> CompressedImage:
    """Read a sensor_msgs/CompressedImage without copying its bytes."""
    return CompressedImage(str(message.format), memoryview(message.data).cast("B"))


def make_state(
    factory: MessageFactory,
    header: Message,
    state: CableState | None,
    sigma: Sequence[float] | FloatArray = (),
) -> Message:
    """Pack a state as named scalars in a sensor_msgs/JointState.

    ``name`` is [d, alpha, w, beta], ``position`` their values [px, rad], ``velocity`` their rates
    [per second], ``effort`` one standard deviation of each (empty for ground truth). Without a
    cable the last three are empty: there is no number that a controller could mistake for one.
    """
    position: FloatArray = np.empty(0)
    velocity: FloatArray = np.empty(0)
    if state is not None:
        values = state.to_array()
        position, velocity = values[:4], values[4:]
    return factory.make(
        "sensor_msgs/msg/JointState",
        header=header,
        name=list(STATE_NAMES),
        position=factory.doubles(position),
        velocity=factory.doubles(velocity),
        effort=factory.doubles(sigma if state is not None else ()),
    )


def read_state(message: Message) -> CableState | None:
    """Read a state packed by `make_state`; None if it claims no cable.

    Raises
    ------
    FrameError
        Names and numbers do not belong together.
    """
    if len(message.position) == 0:
        return None
    names = [str(name) for name in message.name]
    missing = [name for name in STATE_NAMES if name not in names]
    if missing or len(message.position) != len(names):
        raise FrameError(f"a state message names {names}, with {len(message.position)} positions")
    columns = [names.index(name) for name in STATE_NAMES]
    values = [float(message.position[column]) for column in columns]
    rates: list[float] = []
    if len(message.velocity) == len(names):
        rates = [float(message.velocity[column]) for column in columns]
    return CableState(*values, *rates)


def read_sigma(message: Message) -> tuple[float, float, float, float] | None:
    """Read the standard deviations of a state packed by `make_state`; None if it has none."""
    if len(message.effort) != len(STATE_NAMES):
        return None
    d, alpha, w, beta = (float(value) for value in message.effort)
    return d, alpha, w, beta


def centreline_covariance(state: CableState, covariance: FloatArray) -> FloatArray:
    """Return the covariance (6, 6) of x, y, z, roll, pitch, yaw of the foot point.

    First-order propagation from d and alpha through f = d (cos alpha, sin alpha). What a line in
    an image says nothing about gets `UNKNOWN_VARIANCE`.
    """
    cos, sin = math.cos(state.angle), math.sin(state.angle)
    jacobian = np.array([[cos, -state.distance * sin], [sin, state.distance * cos], [0.0, 1.0]])
    columns = [StateColumn.DISTANCE, StateColumn.ANGLE]
    known = jacobian @ covariance[np.ix_(columns, columns)] @ jacobian.T
    result = np.diag(np.full(6, UNKNOWN_VARIANCE))
    result[np.ix_([0, 1, 5], [0, 1, 5])] = (known + known.T) / 2
    return result


def make_centreline(
    factory: MessageFactory, header: Message, state: CableState, covariance: FloatArray
) -> Message:
    """Pack foot point [px] and direction of the centreline as a PoseWithCovarianceStamped."""
    x, y = foot_point(state.distance, state.angle)
    pose = factory.make(
        "geometry_msgs/msg/Pose",
        position=factory.make("geometry_msgs/msg/Point", x=x, y=y, z=0.0),
        orientation=factory.make(
            "geometry_msgs/msg/Quaternion",
            x=0.0,
            y=0.0,
            z=math.sin(state.angle / 2),
            w=math.cos(state.angle / 2),
        ),
    )
    with_covariance = factory.make(
        "geometry_msgs/msg/PoseWithCovariance",
        pose=pose,
        covariance=centreline_covariance(state, covariance).reshape(-1),
    )
    return factory.make(
        "geometry_msgs/msg/PoseWithCovarianceStamped", header=header, pose=with_covariance
    )


def _yaw(orientation: Message) -> float:
    x, y, z, w = (float(getattr(orientation, axis)) for axis in "xyzw")
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not math.isfinite(norm) or abs(norm - 1.0) > 0.1:
        raise FrameError("the orientation of the initial state is no unit quaternion")
    return yaw_of(orientation)


def yaw_of(quaternion: Message) -> float:
    """Return the yaw of a Quaternion [rad], whatever its length."""
    q = quaternion
    return math.atan2(2 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z)


def read_prior(message: Message) -> GivenState:
    """Read an initial state, encoded like `centreline`.

    Width, skew and rates are not part of it and count as not known. So does a variance of
    `UNKNOWN_VARIANCE` or more. A variance of zero means "not said".

    Raises
    ------
    FrameError
        It has numbers that are not finite, or no unit quaternion.
    """
    pose = message.pose.pose
    x, y, angle = float(pose.position.x), float(pose.position.y), _yaw(pose.orientation)
    covariance = np.asarray(message.pose.covariance, dtype=np.float64).reshape(6, 6)
    normal = np.array([math.cos(angle), math.sin(angle)])
    distance = float(normal @ [x, y])
    variances = np.array([normal @ covariance[:2, :2] @ normal, covariance[5, 5]])
    if not (math.isfinite(distance) and bool(np.all(variances >= 0.0))):
        raise FrameError("the initial state has numbers that are not finite, or negative variances")
    state = CableState(distance, angle, 0.0)
    sigma = np.full(STATE_SIZE, np.inf)
    sigma[:2] = np.where(variances == 0.0, np.nan, np.sqrt(variances))
    sigma[:2][variances >= UNKNOWN_VARIANCE] = np.inf
    return GivenState(state, sigma)


def cloud_of(particles: Particles) -> FloatArray:
    """Return the eight state columns and the weight of each particle, shape (N, 9)."""
    return np.column_stack((particles.states, particles.weights))


def make_particles(factory: MessageFactory, header: Message, cloud: FloatArray) -> Message:
    """Pack particles (N, 9) as a PointCloud2 of float32.

    Fields x, y, z (foot point [px], z = 0, for rviz), d, alpha, w, beta, v_d, v_alpha, v_w, v_beta
    [px, rad, per second], weight (summing to one).
    """
    distance, angle = cloud[:, StateColumn.DISTANCE], cloud[:, StateColumn.ANGLE]
    points = np.column_stack(
        (distance * np.cos(angle), distance * np.sin(angle), np.zeros(len(cloud)), cloud)
    )
    return point_cloud(factory, header, CLOUD_COLUMNS, points)


def point_cloud(
    factory: MessageFactory, header: Message, names: Sequence[str], points: FloatArray
) -> Message:
    """Pack points (N, K) as a PointCloud2 of float32 whose K fields have names."""
    packed = points.astype("<f4")
    fields = [
        factory.make(
            "sensor_msgs/msg/PointField",
            name=name,
            offset=4 * column,
            datatype=POINT_FIELD_FLOAT32,
            count=1,
        )
        for column, name in enumerate(names)
    ]
    step = 4 * len(names)
    return factory.make(
        "sensor_msgs/msg/PointCloud2",
        header=header,
        height=1,
        width=len(packed),
        fields=fields,
        is_bigendian=False,
        point_step=step,
        row_step=step * len(packed),
        data=factory.octets(packed.tobytes()),
        is_dense=True,
    )


def read_cloud(message: Message) -> FloatArray:
    """Read particles packed by `make_particles`; shape (N, 9)."""
    points = np.frombuffer(memoryview(message.data).cast("B"), dtype="<f4")
    columns = points.reshape(-1, len(CLOUD_COLUMNS))[:, 3:]
    return columns.astype(np.float64)


def _points(factory: MessageFactory, line: Sequence[tuple[float, float]]) -> list[Message]:
    return [
        factory.make(
            "geometry_msgs/msg/Point", x=x * METRES_PER_PIXEL, y=y * METRES_PER_PIXEL, z=0.0
        )
        for x, y in line
    ]


def _pose_at_origin(factory: MessageFactory) -> Message:
    # Said in full: rosbags knows no default values, and its zero quaternion is no rotation.
    orientation = factory.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    return factory.make("geometry_msgs/msg/Pose", orientation=orientation)


def _line_marker(
    factory: MessageFactory,
    header: Message,
    *,
    number: int,
    name: str,
    points: Sequence[tuple[float, float]],
    colour: tuple[float, float, float],
) -> Message:
    red, green, blue = colour
    return factory.make(
        "visualization_msgs/msg/Marker",
        header=header,
        ns=name,
        id=number,
        type=MARKER_LINE_LIST,
        action=MARKER_ADD,
        pose=_pose_at_origin(factory),
        scale=factory.make("geometry_msgs/msg/Vector3", x=2 * METRES_PER_PIXEL, y=0.0, z=0.0),
        color=factory.make("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0),
        points=_points(factory, points),
    )


def make_markers(
    factory: MessageFactory,
    header: Message,
    state: CableState | None,
    image_size: tuple[int, int],
) -> Message:
    """Pack borders, centreline and image frame as a MarkerArray, 0.01 m to the pixel.

    Without a cable the lines of before are deleted.
    """

    def line(
        number: int,
        name: str,
        points: Sequence[tuple[float, float]],
        colour: tuple[float, float, float],
    ) -> Message:
        return _line_marker(factory, header, number=number, name=name, points=points, colour=colour)

    markers = [
        factory.make(
            "visualization_msgs/msg/Marker",
            header=header,
            action=MARKER_DELETE_ALL,
            pose=_pose_at_origin(factory),
        ),
        line(0, "image", _rectangle(image_size), (0.5, 0.5, 0.5)),
    ]
    if state is not None:
        centre = segment_inside(state.angle, state.distance, image_size) or ()
        markers += [
            line(1, "borders", _border_segments(state, image_size), (0.0, 0.75, 0.375)),
            line(2, "centreline", centre, (1.0, 0.75, 0.0)),
        ]
    return factory.make("visualization_msgs/msg/MarkerArray", markers=markers)


def _border_segments(state: CableState, image_size: tuple[int, int]) -> list[tuple[float, float]]:
    borders = project_borders(state.to_array()[None, :])
    ends: list[tuple[float, float]] = []
    for angle, offset in zip(borders.angles[0], borders.offsets[0], strict=True):
        ends += segment_inside(angle, offset, image_size) or ()
    return ends


def _rectangle(image_size: tuple[int, int]) -> list[tuple[float, float]]:
    x, y = (image_size[0] - 1) / 2, (image_size[1] - 1) / 2
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    return [point for k in range(4) for point in (corners[k], corners[(k + 1) % 4])]


def make_report(
    factory: MessageFactory, header: Message, status: str, values: Mapping[str, str]
) -> Message:
    """Pack what was done with one frame as a DiagnosticArray: its status and further facts."""
    pairs = [
        factory.make("diagnostic_msgs/msg/KeyValue", key=key, value=value)
        for key, value in values.items()
    ]
    entry = factory.make(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=factory.octet(0),
        name="cable_tracker: frame",
        message=status,
        hardware_id=str(header.frame_id),
        values=pairs,
    )
    return factory.make("diagnostic_msgs/msg/DiagnosticArray", header=header, status=[entry])


def report_facts(report: Message) -> dict[str, str]:
    """Return the facts of a message that `make_report` made, by name."""
    return {str(pair.key): str(pair.value) for pair in report.status[0].values}


def fact_number(facts: Mapping[str, str], name: str) -> float | None:
    """Return a fact that is a number; None: it is empty, or missing."""
    text = facts.get(name, "")
    return float(text) if text else None


def report_values(estimate: CableEstimate, ms: float) -> dict[str, str]:
    """Return the facts about one tracked frame that `make_report` publishes.

    What the filter has no notion of is empty.
    """
    probabilities = [f"{hypothesis.probability:.3f}" for hypothesis in estimate.hypotheses]
    return {
        "n_eff": repr(estimate.effective_sample_size),
        "ms": repr(ms),
        "evidence": repr(estimate.evidence),
        "presence": "" if estimate.presence is None else repr(estimate.presence),
        "hypotheses": " ".join(probabilities),
        "event": estimate.event,
    }
