"""Messages about a cable, and which of them there are of a frame.

The image frame has its origin at the image centre, x right, y up [px].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import foot_point
from cable_tracker.cable.model.initial_state import GivenPoint, GivenState
from cable_tracker.cable.model.segments import Segment, border_segments, centreline_segments
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SYMBOLS,
    STATE_SIZE,
    STATE_SYMBOLS,
    CableState,
)
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
    UNKNOWN_VARIANCE,
    YAW,
    X,
    Y,
    make_stamped_pose,
    pose_covariance,
    unit_quaternion,
    yaw_of,
)
from cable_tracker.tracking.image_frame import image_centre

NOT_KNOWN = UNKNOWN_VARIANCE * (1.0 - 1e-9)
"""Least variance that counts as not known: a turned covariance loses the last digits."""

COUNTS = 0.1
"""Least share with which an x or y that is not known leaves d not known, too; from there on even a
standard deviation of 1000 px for it would say nothing of d within a picture."""

CLOUD_COLUMNS = ("x", "y", "z", *STATE_SYMBOLS, "weight")


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
    values = state.to_array() if state is not None else np.empty(0)
    return factory.make(
        node_topics.STATE.type_name,
        header=header,
        name=list(POSE_SYMBOLS),
        position=factory.doubles(values[:4]),
        velocity=factory.doubles(values[4:]),
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
    missing = [name for name in POSE_SYMBOLS if name not in names]
    if missing or len(message.position) != len(names):
        raise FrameError(f"a state message names {names}, with {len(message.position)} positions")
    columns = [names.index(name) for name in POSE_SYMBOLS]
    values = [float(message.position[column]) for column in columns]
    rates: list[float] = []
    if len(message.velocity) == len(names):
        rates = [float(message.velocity[column]) for column in columns]
    return CableState(*values, *rates)


def read_sigma(message: Message) -> tuple[float, float, float, float] | None:
    """Read the standard deviations of a state packed by `make_state`; None if it has none."""
    if len(message.effort) != len(POSE_SYMBOLS):
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
    columns = [DISTANCE, ANGLE]
    known = jacobian @ covariance[np.ix_(columns, columns)] @ jacobian.T
    return pose_covariance((X, Y, YAW), known)


def make_centreline(
    factory: MessageFactory, header: Message, state: CableState, covariance: FloatArray
) -> Message:
    """Pack foot point [px] and direction of the centreline as a PoseWithCovarianceStamped."""
    x, y = foot_point(state.distance, state.angle)
    known = centreline_covariance(state, covariance)
    return make_stamped_pose(factory, header, (x, y, 0.0), state.angle, known)


def read_prior(message: Message) -> GivenState:
    """Read an initial state, encoded like `centreline`.

    Width, skew and rates are not part of it and count as not known. So does a variance of
    `UNKNOWN_VARIANCE` or more. A variance of zero means "not said". If x and y are known and the
    yaw is not, they are a point that the cable passes.

    Raises
    ------
    FrameError
        It has numbers that are not finite, or no unit quaternion.
    """
    pose = message.pose.pose
    if unit_quaternion(pose.orientation) is None:
        raise FrameError("the orientation of the initial state is no unit quaternion")
    x, y, angle = float(pose.position.x), float(pose.position.y), yaw_of(pose.orientation)
    covariance = np.asarray(message.pose.covariance, dtype=np.float64).reshape(6, 6)
    normal = np.array([math.cos(angle), math.sin(angle)])
    distance = float(normal @ [x, y])
    is_line = bool(covariance[YAW, YAW] < NOT_KNOWN)
    variances = np.array([
        _variance_across(covariance[:2, :2], normal if is_line else None), covariance[YAW, YAW]
    ])  # fmt: skip
    if not (math.isfinite(distance) and bool(np.all(variances >= 0.0))):
        raise FrameError("the initial state has numbers that are not finite, or negative variances")
    state = CableState(distance, angle, 0.0)
    sigma = np.full(STATE_SIZE, np.inf)
    sigma[:2] = np.where(variances == 0.0, np.nan, np.sqrt(variances))
    sigma[:2][variances >= NOT_KNOWN] = np.inf
    if is_line:
        return GivenState(state, sigma)
    # Without a direction, d is that of no line.
    point = None if math.isinf(sigma[0]) else GivenPoint(x, y, float(sigma[0]))
    sigma[0] = np.inf
    return GivenState(state, sigma, point=point)


def _variance_across(covariance: FloatArray, normal: FloatArray | None) -> float:
    """Return the variance of a position along a normal [px²].

    It is `UNKNOWN_VARIANCE` or more if an x or y that counts there is not known.

    Parameters
    ----------
    covariance : FloatArray
        Covariance of x and y, shape (2, 2).
    normal : FloatArray or None
        Shape (2,). None: the mean over all directions.
    """
    is_missing = np.diag(covariance) >= NOT_KNOWN
    counts = np.ones(2, bool) if normal is None else np.abs(normal) > COUNTS
    if bool((is_missing & counts).any()):
        return UNKNOWN_VARIANCE
    if normal is None:
        return float(np.trace(covariance) / 2)
    return float(normal @ covariance @ normal)


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


def cloud_of(particles: Particles) -> FloatArray:
    """Return the eight state columns and the weight of each particle, shape (N, 9)."""
    return np.column_stack((particles.states, particles.weights))


def make_particles(factory: MessageFactory, header: Message, cloud: FloatArray) -> Message:
    """Pack particles (N, 9) as a PointCloud2 of float32.

    Fields x, y, z (foot point [px], z = 0, for rviz), d, alpha, w, beta, v_d, v_alpha, v_w, v_beta
    [px, rad, per second], weight (summing to one).
    """
    distance, angle = cloud[:, DISTANCE], cloud[:, ANGLE]
    points = np.column_stack(
        (distance * np.cos(angle), distance * np.sin(angle), np.zeros(len(cloud)), cloud)
    )
    return make_point_cloud(factory, header, CLOUD_COLUMNS, points)


def read_particles(message: Message) -> FloatArray:
    """Read particles packed by `make_particles`; shape (N, 9)."""
    return read_point_cloud(message, CLOUD_COLUMNS)[:, 3:]


def make_markers(
    factory: MessageFactory,
    header: Message,
    state: CableState | None,
    image_size: tuple[int, int],
) -> Message:
    """Pack borders, centreline and image frame as a MarkerArray, 0.01 m to the pixel.

    Without a cable the lines of before are deleted.
    """
    drawn = [Lines("image", sides_of_polygon(_pixel_corners(image_size)), GREY)]
    if state is not None:
        drawn += [
            Lines("borders", _ends(border_segments(state, image_size)), GREEN),
            Lines("centreline", _ends(centreline_segments(state, image_size)), AMBER),
        ]
    return make_line_markers(factory, header, drawn)


def cable_messages(
    factory: MessageFactory,
    header: Message,
    estimate: CableEstimate,
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
    estimate : CableEstimate
        Estimate of the frame [px, rad].
    particles : Particles or None
        Particles after the frame; None: the filter has none.
    ms : float
        Time the tracker took [ms].
    metres : callable
        Returns what the report says in metres, see `cable_facts`; called when the report is made.
    """
    claimed = estimate.claimed_state

    def make_frame_report() -> Message:
        values = report_values(estimate, ms) | dict(metres())
        return make_report(factory, header, estimate.status.value, values)

    makers: MessageMakers = {
        node_topics.STATE: lambda: make_state(
            factory, header, claimed, estimate.standard_deviations()[:4]
        ),
        node_topics.FRAME_REPORT: make_frame_report,
    }
    if claimed is not None:
        makers[node_topics.CENTRELINE] = lambda: make_centreline(
            factory, header, claimed, estimate.covariance
        )
    if particles is not None:
        makers[node_topics.PARTICLES] = lambda: make_particles(factory, header, cloud_of(particles))
    makers[node_topics.MARKERS] = lambda: make_markers(
        factory, header, claimed, estimate.image_size
    )
    return makers


def messages_without_cable(
    factory: MessageFactory, header: Message, status: str, reason: str
) -> MessageMakers:
    """Return makers of the messages about a frame without an estimate, by status and reason."""
    return {
        node_topics.STATE: lambda: make_state(factory, header, None),
        node_topics.FRAME_REPORT: lambda: make_report(factory, header, status, {"event": reason}),
    }


def _ends(segments: list[Segment]) -> FloatArray:
    """Return the ends of K segments, one after the other, shape (2K, 2) [px]."""
    return np.array(segments, dtype=np.float64).reshape(-1, 2)


def _pixel_corners(image_size: tuple[int, int]) -> FloatArray:
    """Return the centres of the corner pixels, shape (4, 2) [px]."""
    x, y = image_centre(image_size)
    return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
