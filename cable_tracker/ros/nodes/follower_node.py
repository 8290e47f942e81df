"""A node that keeps its distance behind a target, as an example of what to do with one."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

from cable_tracker.example_controller.command import Command
from cable_tracker.example_controller.target_follower import (
    FollowMode,
    FollowSettings,
    TargetController,
    TargetPlace,
)
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import subscription
from cable_tracker.ros.nodes.guidance_node import GuidanceNode, keep
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.stamps import NANOSECONDS


class FollowerNode(GuidanceNode[FollowSettings]):
    """Follows a target, answering each `state` of the target tracker with a `cmd_vel`.

    Parameters
    ----------
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter is not acceptable.
    """

    NOMINAL_MODE = FollowMode.FOLLOWING
    TOPICS = node_topics.TARGET_TOPICS

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__("follower", FollowSettings(), **node_arguments)
        self._follower = TargetController(self._settings)
        self._positions: OrderedDict[int, TargetPlace] = OrderedDict()
        subscription(self, self.TOPICS.pose, self.on_relative_pose, qos.RESULTS)

    @property
    def mode(self) -> FollowMode:
        """Mode of the follower, as diagnostics show it."""
        return self._follower.mode

    def on_relative_pose(self, message: Message) -> None:
        """Remember where the target was."""
        position = message.pose.pose.position
        kept = TargetPlace(float(position.x), float(position.y), float(position.z))
        keep(self._positions, stamp_of(message.header), kept)

    def _is_complete(self, stamp: int, has_position: bool) -> bool:
        return stamp in self._positions or not has_position

    def _command(self, stamp: int, is_claimed: bool, is_processed: bool) -> Command:
        position = self._positions.get(stamp) if is_claimed else None
        return self._follower.step(stamp / NANOSECONDS, position)
