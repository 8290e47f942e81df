"""A node that follows the cable, as an example: `cross_track` in, `cmd_vel` out."""

from __future__ import annotations

import math
from collections import OrderedDict
from typing import Any

from cable_tracker.example_controller.cable_memory import Pose
from cable_tracker.example_controller.command import Command
from cable_tracker.example_controller.controller import Controller, ControllerSettings, Mode
from cable_tracker.example_controller.line_of_sight import CableLine
from cable_tracker.metric.odometry.motion import LONGEST_HOLD
from cable_tracker.node_parameter_tables import BEST_EFFORT, RELIABLE
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import subscription
from cable_tracker.ros.nodes.guidance_node import GuidanceNode, keep
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.messages.poses import unit_quaternion, yaw_of
from cable_tracker.stamps import NANOSECONDS


class ControllerNode(GuidanceNode[ControllerSettings]):
    """Steers along the cable, answering each `state` of the tracker with a `cmd_vel`.

    Parameters
    ----------
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter is not acceptable.
    """

    NOMINAL_MODE = Mode.FOLLOWING
    TOPICS = node_topics.CABLE_TOPICS

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__("controller", ControllerSettings(), **node_arguments)
        self._controller = Controller(self._settings)
        self._cables: OrderedDict[int, CableLine] = OrderedDict()
        self._poses: OrderedDict[int, Pose] = OrderedDict()
        reliability = RELIABLE if self._own.lockstep else BEST_EFFORT
        subscription(
            self, node_topics.ODOMETRY, self.on_odometry, qos.instrument_input(reliability)
        )
        subscription(self, self.TOPICS.pose, self.on_cross_track, qos.RESULTS)

    @property
    def mode(self) -> Mode:
        """Mode of the controller, as diagnostics show it."""
        return self._controller.mode

    def on_odometry(self, message: Message) -> None:
        """Remember where the vehicle was, unless odometry does not know."""
        pose = message.pose.pose
        # Its yaw would be 0: a search would turn towards that again and again.
        if unit_quaternion(pose.orientation) is None:
            return
        read = Pose(float(pose.position.x), float(pose.position.y), yaw_of(pose.orientation))
        if all(map(math.isfinite, (read.x, read.y, read.yaw))):
            stamp = stamp_of(message.header) or int(self.get_clock().now().nanoseconds)
            keep(self._poses, stamp, read)

    def on_cross_track(self, message: Message) -> None:
        """Remember where the cable was."""
        pose = message.pose.pose
        cable = CableLine(float(pose.position.y), yaw_of(pose.orientation))
        keep(self._cables, stamp_of(message.header), cable)

    def _is_complete(self, stamp: int, has_position: bool) -> bool:
        return self._knows_pose(stamp) and (stamp in self._cables or not has_position)

    def _knows_pose(self, stamp: int) -> bool:
        """Tell whether waiting would bring no better pose for a time [ns]."""
        if self._own.lockstep:
            return stamp in self._poses
        # On a vehicle odometry has a clock of its own: its stamps are never the camera's.
        if not self._poses or max(self._poses) >= stamp:
            return True
        return self._pose_at(stamp) is not None

    def _pose_at(self, stamp: int) -> Pose | None:
        """Return where the vehicle was at a time [ns], or just before or after; None: not known."""
        # The newest may be of long after the picture: the tracker takes its time.
        nearest = min(self._poses, key=lambda kept: abs(kept - stamp), default=None)
        if nearest is None or abs(stamp - nearest) > LONGEST_HOLD * NANOSECONDS:
            return None
        return self._poses[nearest]

    def _command(self, stamp: int, is_claimed: bool, is_processed: bool) -> Command:
        cable = self._cables.get(stamp) if is_claimed else None
        seconds, pose = stamp / NANOSECONDS, self._pose_at(stamp)
        return self._controller.step(seconds, cable, pose, is_processed=is_processed)
