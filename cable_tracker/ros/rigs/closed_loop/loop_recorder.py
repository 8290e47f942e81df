"""Listens to a closed loop and puts together what belongs to the same frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial

from rclpy.context import Context

from cable_tracker.arrays import Image as Picture
from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.closed_loop.loop_table import LoopRow
from cable_tracker.ros.rigs.closed_loop.run_recorder import RunRecorder
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.messages.cable import read_state
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import report_status
from cable_tracker.sequences.messages.images import read_image
from cable_tracker.sequences.messages.poses import Y, yaw_of
from cable_tracker.stamps import NANOSECONDS


@dataclass(slots=True)
class _Frame:
    """Messages about one frame, as far as they have come."""

    image: Message | None = None
    state: Message | None = None
    report: Message | None = None
    odometry: Message | None = None
    truth: Message | None = None
    cable: Message | None = None

    def is_seen(self, *, with_image: bool) -> bool:
        """Tell whether all has come that a picture of the frame needs."""
        needed = [self.state, self.report, self.odometry, self.truth]
        if with_image:
            needed.append(self.image)
        return all(each is not None for each in needed)

    def is_sent(self) -> bool:
        """Tell whether the simulator has sent it, or begun to."""
        return self.truth is not None or self.image is not None


@dataclass(frozen=True, slots=True, eq=False)
class SeenFrame:
    """Content of a frame's picture in the video.

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


@dataclass(slots=True)
class _Modes:
    """When the controller changed its mode, by stamp [ns]."""

    changes: dict[int, str] = field(default_factory=dict)

    def at(self, stamp: int) -> str:
        """Return the mode at a time."""
        known = [time for time in self.changes if time <= stamp]
        return self.changes[max(known)] if known else "WAITING"


class LoopRecorder(RunRecorder):
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

    def __init__(self, context: Context, namespace: str, *, with_images: bool = True) -> None:
        super().__init__("loop_recorder", context, namespace)
        self._frames: dict[int, _Frame] = {}
        self._undrawn: dict[int, _Frame] = {}
        self._modes = _Modes()
        self._with_images = with_images
        self._drawn = -1
        self._taken = 0
        for topic, name in (
            *([(node_topics.IMAGE, "image")] if with_images else []),
            (node_topics.STATE, "state"),
            (node_topics.FRAME_REPORT, "report"),
            (node_topics.TRUE_ODOMETRY, "odometry"),
            (node_topics.TRUE_CROSS_TRACK, "truth"),
            (node_topics.CROSS_TRACK, "cable"),
        ):
            self._record(topic, partial(self._keep, name))

    def _keep(self, name: str, stamp: int, message: Message) -> None:
        if stamp not in self._frames:
            self._frames[stamp] = self._undrawn[stamp] = _Frame()
        setattr(self._frames[stamp], name, message)

    def _note_mode(self, stamp: int, mode: str) -> None:
        self._modes.changes[stamp] = mode

    def is_connected(self) -> bool:
        """Tell whether the tracker knows both the controller and us; it says so in diagnostics."""
        both = self._told.has_readers(2, node_topics.STATE, node_topics.CROSS_TRACK)
        return both and self._told.has_readers(1, node_topics.FRAME_REPORT)

    def is_warm(self) -> bool:
        """Tell whether the tracker has said that it is done with compiling."""
        return self._told.is_warm

    def take(self) -> list[SeenFrame]:
        """Return the frames that have become complete, in order, each once.

        A frame that the tracker has left out is passed over when a later one is complete. In
        lockstep the simulator goes on when a frame is complete.
        """
        complete = sorted(stamp for stamp, frame in self._undrawn.items() if self._sees(frame))
        seen = [_seen(stamp, self._undrawn[stamp]) for stamp in complete if stamp > self._drawn]
        self._drawn = max([self._drawn, *complete])
        self._taken += len(seen)
        self._commands.release(self._taken)
        for stamp in [stamp for stamp in self._undrawn if stamp <= self._drawn]:
            self._undrawn.pop(stamp).image = None
        return seen

    def _sees(self, frame: _Frame) -> bool:
        return frame.is_seen(with_image=self._with_images)

    def is_settled(self) -> bool:
        """Tell whether all messages about the frames sent have come."""
        return not any(frame.is_sent() for frame in self._undrawn.values())

    def is_steered(self) -> bool:
        """Tell whether there is a command for each frame that has been complete."""
        return self._commands.heard >= self._taken

    def rows(self) -> list[LoopRow]:
        """Return the table of the run; its frames are those that the simulator sent."""
        stamps = sorted(s for s, f in self._frames.items() if f.truth is not None and f.odometry)
        return [self._row(stamp, stamps[0]) for stamp in stamps]

    def _row(self, stamp: int, first: int) -> LoopRow:
        frame = self._frames[stamp]
        assert frame.odometry is not None and frame.truth is not None
        pose, twist = frame.odometry.pose.pose, frame.odometry.twist.twist.linear
        true = frame.truth.pose.pose
        heading = yaw_of(true.orientation)
        offset, measured_heading, sigma = math.nan, math.nan, math.nan
        if frame.cable is not None:
            measured = frame.cable.pose
            offset = float(measured.pose.position.y)
            measured_heading = yaw_of(measured.pose.orientation)
            sigma = math.sqrt(max(float(measured.covariance[7 * Y]), 0.0))
        return LoopRow(
            time=(stamp - first) / NANOSECONDS,
            x=float(pose.position.x),
            y=float(pose.position.y),
            altitude=float(pose.position.z),
            yaw=yaw_of(pose.orientation),
            speed=math.hypot(twist.x, twist.y),
            status=report_status(frame.report) if frame.report else "",
            mode=self._modes.at(stamp),
            error=float(true.position.y) * math.cos(heading),
            heading=heading,
            offset=float(true.position.y),
            measured_offset=offset,
            measured_heading=measured_heading,
            sigma_offset=sigma,
        )


def _seen(stamp: int, frame: _Frame) -> SeenFrame:
    assert frame.odometry is not None and frame.truth is not None and frame.report is not None
    pose, true = frame.odometry.pose.pose, frame.truth.pose.pose
    return SeenFrame(
        stamp=stamp,
        image=decode_grey(read_image(frame.image)) if frame.image is not None else None,
        state=read_state(frame.state),
        status=report_status(frame.report),
        place=(float(pose.position.x), float(pose.position.y)),
        yaw=yaw_of(pose.orientation),
        error=float(true.position.y) * math.cos(yaw_of(true.orientation)),
    )
