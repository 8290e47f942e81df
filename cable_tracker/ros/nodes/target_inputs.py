"""The part of the target tracker that knows the vehicle: calibration and motion in, metres out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import cast

from nav_msgs.msg import Odometry as OdometryMessage
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Imu

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.recorded_target import target_settings
from cable_tracker.metric.relative_state import RelativeState
from cable_tracker.metric.target_metres import TargetMetres
from cable_tracker.metric.target_sight import TargetSight
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import TARGET_METRIC_PARAMETERS
from cable_tracker.ros import qos
from cable_tracker.ros.inputs.callbacks import followed_by
from cable_tracker.ros.inputs.instruments_sent import InstrumentsSent
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.estimate import TargetEstimate

INSTRUMENTS = (node_topics.IMU, node_topics.ODOMETRY)
"""Instruments whose measurements have a time."""


class TargetInputs:
    """Listens to the instruments, and turns estimates into bearings and ranges.

    Parameters
    ----------
    node : Node
        The node.
    count : int
        How many targets it follows.
    """

    def __init__(self, node: Node, count: int) -> None:
        self._node = node
        self._values: dict[str, object] = {
            spec.name: spec.default for spec in TARGET_METRIC_PARAMETERS
        }
        self._sight = TargetSight(target_settings(self._values), count)
        self._info: Message | None = None
        self._newest: dict[NodeTopic, int] = {}
        self._heard: Counter[str] = Counter()
        self._sent = InstrumentsSent((node_topics.CAMERA_INFO, *INSTRUMENTS))
        self._results: list[TargetMetres] = []

    def subscribe(self, reliability: str, on_news: Callable[[], None]) -> None:
        """Listen, `best_effort` or `reliable`; `on_news` is called after each message."""
        profile = qos.instrument_input(reliability)
        for kind, topic, take in (
            (CameraInfo, node_topics.CAMERA_INFO, self.on_camera_info),
            (Imu, node_topics.IMU, self.on_imu),
            (OdometryMessage, node_topics.ODOMETRY, self.on_odometry),
        ):
            self._node.create_subscription(kind, topic.name, followed_by(take, on_news), profile)
        self._sent.subscribe(self._node, reliability, on_news)

    @property
    def wait(self) -> float:
        """How long a frame may be held back for the instruments [s]."""
        return self._number("instrument_wait")

    @property
    def base_frame(self) -> str:
        """Frame of what is in metres."""
        return str(self._values["base_frame"])

    @property
    def camera_place(self) -> FloatArray:
        """Position of the camera in `base_frame`, shape (3,) [m]."""
        return self._sight.settings.mounting.position

    @property
    def results(self) -> Sequence[TargetMetres]:
        """Metres of each target in the last frame; empty before the first."""
        return self._results

    def has_all_of(self, stamp: int) -> bool:
        """Tell whether calibration and motion are known at a time [ns].

        Each of imu and odometry that has spoken before must have spoken of that time or later: who
        comes first must not decide whose motion is taken. Where a replay says how much it has sent
        before the frame of that time, all of it must have come.
        """
        if self._sent.tells_of(stamp):
            return self._sent.has_come(self._heard)
        motion = self._newest.values()
        return self._info is not None and bool(motion) and min(motion) >= stamp

    def apply(self, values: Mapping[str, object]) -> None:
        """Take what is given of `TARGET_METRIC_PARAMETERS`, by name."""
        own = {name: values[name] for name in values.keys() & self._values.keys()}
        if not own:
            return
        self._values.update(own)
        self._sight.configure(target_settings(self._values))
        if self._info is not None:
            self._use_calibration(self._info)

    def forget(self, number: int | None = None) -> None:
        """Begin anew with the range of one target, or of all."""
        self._sight.forget(number)

    def on_camera_info(self, message: Message) -> None:
        """Take a calibration."""
        self._heard[node_topics.CAMERA_INFO.name] += 1
        self._use_calibration(message)

    def _use_calibration(self, message: Message) -> None:
        is_rectified = bool(self._values["image_is_rectified"])
        self._sight.take_camera_info(message, is_rectified=is_rectified)
        self._info = message

    def on_imu(self, message: Message) -> None:
        """Take rates of turn."""
        self._sight.take_imu(self._note(node_topics.IMU, message), message)

    def on_odometry(self, message: Message) -> None:
        """Take a twist of base_link."""
        self._sight.take_odometry(self._note(node_topics.ODOMETRY, message), message)

    def camera_motion(self, stamp: int, image_size: tuple[int, int]) -> CameraMotion | None:
        """Return what turns of the vehicle did to the picture; see `TargetSight`."""
        return self._sight.camera_motion(stamp, image_size)

    def take(self, estimates: Sequence[TargetEstimate]) -> Sequence[TargetMetres]:
        """Return what a frame's estimates are in metres; once for each frame."""
        before, self._results = self._results, self._sight.take(estimates)
        for number, result in enumerate(self._results):
            self._tell(before[number] if number < len(before) else None, result)
        return self._results

    def figures(self, number: int) -> dict[str, str]:
        """Return what diagnostics say of the metres of a target, with units in the keys."""
        result = self._results[number] if number < len(self._results) else None
        relative = result.relative if result is not None else None
        is_known = isinstance(relative, RelativeState)
        return {
            "range [m]": f"{relative.range:.2f}" if isinstance(relative, RelativeState) else "",
            "range sigma [m]": (
                f"{relative.range_sigma:.2f}" if isinstance(relative, RelativeState) else ""
            ),
            "no metres": "" if is_known or relative is None else str(relative),
        }

    @property
    def why_unaided(self) -> str:
        """Why turns were not taken out of the last frame; empty if they were."""
        return self._sight.why_unaided

    def _tell(self, before: TargetMetres | None, result: TargetMetres) -> None:
        """Say once why there are no metres. That no target is claimed is said elsewhere."""
        why = result.relative
        if not isinstance(why, Withheld) or why.reason is Reason.NO_TARGET:
            return
        known = before.relative if before is not None else None
        if not isinstance(known, Withheld) or known.reason is not why.reason:
            self._node.get_logger().info(f"no relative_pose: {why}", throttle_duration_sec=10.0)

    def _number(self, name: str) -> float:
        return float(cast(float, self._values[name]))

    def _note(self, topic: NodeTopic, message: Message) -> int:
        """Return the stamp of an instrument's message [ns], and remember it."""
        stamp = stamp_of(message.header) or int(self._node.get_clock().now().nanoseconds)
        self._newest[topic] = stamp
        self._heard[topic.name] += 1
        return stamp
