"""A node that keeps its distance behind a target, as an example of what to do with one."""

from __future__ import annotations

import time
from collections import OrderedDict
from dataclasses import fields
from typing import Any, cast

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from sensor_msgs.msg import JointState

from cable_tracker.example_controller.target_follower import (
    FollowCommand,
    FollowMode,
    FollowSettings,
    TargetFollower,
    TargetPlace,
)
from cable_tracker.node_parameter_tables import FOLLOWER_PARAMETERS
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.process.process_node import WAKE_UP, ProcessNode
from cable_tracker.sequences.messages import Message, stamp_of
from cable_tracker.sequences.stamps import NANOSECONDS

KEPT = 100
"""Places that are kept until their `state` comes."""

POLL = 0.005
"""Longest sleep while a `state` waits for what belongs to it [s]."""


class FollowerNode(ProcessNode):
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

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__("follower", **node_arguments)
        self._values = node_parameters.declare_all(self, FOLLOWER_PARAMETERS, read_only=True)
        node_parameters.warn_of_unknown_overrides(self)
        self._follower = TargetFollower(
            FollowSettings(
                **{each.name: self._number(each.name) for each in fields(FollowSettings)}
            )
        )
        self._told: FollowMode | None = None
        self._places: OrderedDict[int, TargetPlace] = OrderedDict()
        self._states: list[tuple[int, bool, float]] = []
        self._last_state = time.monotonic()
        self._stopped = False
        self._commands = self.create_publisher(Twist, "cmd_vel", qos.RESULTS)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", qos.RESULTS)
        self.create_subscription(
            PoseWithCovarianceStamped, "relative_pose", self.on_relative_pose, qos.RESULTS
        )
        self.create_subscription(JointState, "state", self.on_state, qos.RESULTS)

    @property
    def mode(self) -> FollowMode:
        """What the follower is about."""
        return self._follower.mode

    def _number(self, name: str) -> float:
        return float(cast(float, self._values[name]))

    def on_relative_pose(self, message: Message) -> None:
        """Remember where the target was."""
        place = message.pose.pose.position
        kept = TargetPlace(float(place.x), float(place.y), float(place.z))
        self._places[stamp_of(message.header)] = kept
        while len(self._places) > KEPT:
            self._places.popitem(last=False)

    def on_state(self, message: Message) -> None:
        """Take note that the tracker has seen a frame, and whether it claims a target in it."""
        now = time.monotonic()
        self._last_state = now
        self._states.append((stamp_of(message.header), bool(message.position), now))

    def seconds_until_due(self) -> float:
        """Return how long the executor may sleep [s]."""
        return POLL if self._states else WAKE_UP

    def work(self) -> None:
        """Answer the oldest `state`, or stop the vehicle if none comes."""
        if self._states:
            self._answer(*self._states[0])
        elif not self._values["lockstep"]:
            self._watch()

    def _answer(self, stamp: int, is_claimed: bool, came: float) -> None:
        # A first command without a subscriber would stop a lockstep simulator for ever.
        if self._values["lockstep"] and not self._commands.get_subscription_count():
            return
        is_complete = stamp in self._places or not is_claimed
        if not is_complete and time.monotonic() - came < self._number("settle_time"):
            return
        self._states.pop(0)
        place = self._places.get(stamp) if is_claimed else None
        self._publish(self._follower.step(stamp / NANOSECONDS, place))
        self._stopped = False
        self._tell(stamp)

    def _watch(self) -> None:
        silent = time.monotonic() - self._last_state > self._number("state_timeout")
        if silent and not self._stopped:
            self._stopped = True
            self.get_logger().warning("no `state` comes from the tracker: the vehicle stops")
            self._publish(FollowCommand())

    def _publish(self, command: FollowCommand) -> None:
        message = Twist()
        message.linear.x = command.surge
        message.linear.z = command.heave
        message.angular.z = command.turn
        self._commands.publish(message)

    def _tell(self, stamp: int) -> None:
        if self.mode is self._told:
            return
        self._told = self.mode
        self.get_logger().info(self.mode.value)
        message = DiagnosticArray()
        seconds, rest = divmod(stamp, NANOSECONDS)
        message.header.stamp.sec, message.header.stamp.nanosec = seconds, rest
        is_well = self.mode is FollowMode.FOLLOWING
        message.status.append(
            DiagnosticStatus(
                level=DiagnosticStatus.OK if is_well else DiagnosticStatus.WARN,
                name=f"{self.get_fully_qualified_name()}: guidance",
                message=self.mode.value,
                hardware_id=self.get_fully_qualified_name(),
            )
        )
        self._diagnostics.publish(message)
