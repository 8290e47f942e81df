"""Recorder of a closed loop: the messages about each frame, and the rows of its table."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rclpy.context import Context

from cable_tracker.arrays import Image as Picture
from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.loop_table import LoopRow
from cable_tracker.ros.rigs.closed_loop.run_recorder import FrameMessages, RunRecorder
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.messages.cable import read_state
from cable_tracker.sequences.messages.frame_report import report_status
from cable_tracker.sequences.messages.images import read_image
from cable_tracker.sequences.messages.poses import Y, yaw_of
from cable_tracker.stamps import NANOSECONDS

TRUTHS = frozenset({node_topics.TRUE_ODOMETRY, node_topics.TRUE_CROSS_TRACK})
"""Topics that a row of the table needs."""

NEEDED = TRUTHS | {node_topics.STATE, node_topics.FRAME_REPORT}
"""Topics that a frame of the video needs besides the image."""


@dataclass(frozen=True, slots=True, eq=False)
class LoopVideoFrame:
    """Content of one frame of the video.

    Attributes
    ----------
    stamp : int
        Time of the frame [ns].
    image : Picture or None
        Grey, uint8, shape (H, W); None without pictures.
    state : CableState or None
        The estimate.
    status : str
        Status of the tracker.
    place : (float, float)
        x, y of the vehicle in the world [m].
    yaw : float
        Yaw of the vehicle [rad].
    error : float
        True distance to the cable [m].
    """

    stamp: int
    image: Picture | None
    state: CableState | None
    status: str
    place: tuple[float, float]
    yaw: float
    error: float


class LoopRecorder(RunRecorder[LoopVideoFrame]):
    """Subscribes to all that a closed loop publishes.

    Parameters
    ----------
    context : Context
        rclpy context of this process.
    namespace : str
        Namespace of the loop's nodes.
    with_images : bool
        Listen to the camera as well.
    """

    RECORDED = (
        node_topics.STATE,
        node_topics.FRAME_REPORT,
        node_topics.TRUE_ODOMETRY,
        node_topics.TRUE_CROSS_TRACK,
        node_topics.CROSS_TRACK,
    )
    PICTURE = node_topics.IMAGE
    SENT = frozenset({node_topics.TRUE_CROSS_TRACK, node_topics.IMAGE})

    def __init__(self, context: Context, namespace: str, *, with_images: bool = True) -> None:
        super().__init__("loop_recorder", context, namespace)
        self._modes: dict[int, str] = {}
        self._needed = NEEDED
        if with_images:
            self._needed |= {node_topics.IMAGE}
            self._record(node_topics.IMAGE)

    def _note_mode(self, stamp: int, mode: str) -> None:
        self._modes[stamp] = mode

    def is_connected(self) -> bool:
        """Tell whether the tracker's diagnostics count the controller and us as readers."""
        both = self._health.has_readers(2, node_topics.STATE, node_topics.CROSS_TRACK)
        return both and self._health.has_readers(1, node_topics.FRAME_REPORT)

    def is_warm(self) -> bool:
        """Tell whether the tracker's diagnostics say that it has compiled."""
        return self._health.is_warm()

    def _is_complete(self, frame: FrameMessages) -> bool:
        return frame.keys() >= self._needed

    def _video_frame(self, stamp: int, frame: FrameMessages) -> LoopVideoFrame:
        image = frame.get(node_topics.IMAGE)
        pose = frame[node_topics.TRUE_ODOMETRY].pose.pose
        true = frame[node_topics.TRUE_CROSS_TRACK].pose.pose
        return LoopVideoFrame(
            stamp=stamp,
            image=decode_grey(read_image(image)) if image is not None else None,
            state=read_state(frame[node_topics.STATE]),
            status=report_status(frame[node_topics.FRAME_REPORT]),
            place=(float(pose.position.x), float(pose.position.y)),
            yaw=yaw_of(pose.orientation),
            error=float(true.position.y) * math.cos(yaw_of(true.orientation)),
        )

    def is_steered(self) -> bool:
        """Tell whether there is a command for each frame that has been complete."""
        return self._commands.received >= self._taken

    def rows(self) -> list[LoopRow]:
        """Return the table of the run; its frames are those that the simulator sent."""
        stamps = sorted(s for s, frame in self._frames.items() if frame.keys() >= TRUTHS)
        return [self._row(stamp, stamps[0]) for stamp in stamps]

    def _row(self, stamp: int, first: int) -> LoopRow:
        frame = self._frames[stamp]
        odometry = frame[node_topics.TRUE_ODOMETRY]
        pose, twist = odometry.pose.pose, odometry.twist.twist.linear
        true = frame[node_topics.TRUE_CROSS_TRACK].pose.pose
        heading = yaw_of(true.orientation)
        offset, measured_heading, sigma = math.nan, math.nan, math.nan
        if node_topics.CROSS_TRACK in frame:
            measured = frame[node_topics.CROSS_TRACK].pose
            offset = float(measured.pose.position.y)
            measured_heading = yaw_of(measured.pose.orientation)
            sigma = math.sqrt(max(float(measured.covariance[7 * Y]), 0.0))
        report = frame.get(node_topics.FRAME_REPORT)
        changed = max((time for time in self._modes if time <= stamp), default=None)
        return LoopRow(
            time=(stamp - first) / NANOSECONDS,
            x=float(pose.position.x),
            y=float(pose.position.y),
            altitude=float(pose.position.z),
            yaw=yaw_of(pose.orientation),
            speed=math.hypot(twist.x, twist.y),
            status=report_status(report) if report is not None else "",
            mode="WAITING" if changed is None else self._modes[changed],
            error=float(true.position.y) * math.cos(heading),
            heading=heading,
            offset=float(true.position.y),
            measured_offset=offset,
            measured_heading=measured_heading,
            sigma_offset=sigma,
        )
