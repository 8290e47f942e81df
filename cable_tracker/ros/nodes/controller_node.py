"""A node that follows the cable, as an example: `cross_track` in, `cmd_vel` out."""

from __future__ import annotations

import time
from collections import OrderedDict
from typing import Any, TypeVar, cast

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

from cable_tracker.example_controller.cable_memory import Pose
from cable_tracker.example_controller.controller import (
    Controller,
    ControllerSettings,
    Mode,
    SearchSettings,
)
from cable_tracker.example_controller.line_of_sight import (
    STOP,
    Cable,
    Command,
    GuidanceSettings,
)
from cable_tracker.metric.messages import yaw_of
from cable_tracker.node_parameter_tables import CONTROLLER_PARAMETERS
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.process.process_node import WAKE_UP, ProcessNode
from cable_tracker.sequences.messages import Message, stamp_of
from cable_tracker.sequences.stamps import NANOSECONDS

Kept = TypeVar("Kept")

KEPT = 100
"""Messages of each kind that are kept until their `state` comes."""

POLL = 0.005
"""Longest sleep while a `state` waits for what belongs to it [s]."""


class ControllerNode(ProcessNode):
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

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__("controller", **node_arguments)
        self._values = node_parameters.declare_all(self, CONTROLLER_PARAMETERS, read_only=True)
        node_parameters.warn_of_unknown_overrides(self)
        self._controller = Controller(self._settings())
        self._told: Mode | None = None
        self._cables: OrderedDict[int, Cable] = OrderedDict()
        self._poses: OrderedDict[int, Pose] = OrderedDict()
        self._states: list[tuple[int, bool, float]] = []
        self._last_state = time.monotonic()
        self._stopped = False
        self._commands = self.create_publisher(Twist, "cmd_vel", qos.RESULTS)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", qos.RESULTS)
        reliability = "reliable" if self._values["lockstep"] else "best_effort"
        self.create_subscription(
            Odometry, "odometry", self.on_odometry, qos.instrument_input(reliability)
        )
        self.create_subscription(
            PoseWithCovarianceStamped, "cross_track", self.on_cross_track, qos.RESULTS
        )
        self.create_subscription(JointState, "state", self.on_state, qos.RESULTS)

    @property
    def mode(self) -> Mode:
        """What the controller is about."""
        return self._controller.mode

    def _number(self, name: str) -> float:
        return float(cast(float, self._values[name]))

    def _settings(self) -> ControllerSettings:
        number = self._number
        return ControllerSettings(
            GuidanceSettings(
                speed=number("speed"),
                look_ahead=number("look_ahead"),
                integral_gain=number("integral_gain"),
                turn_gain=number("turn_gain"),
                most_turn=number("most_turn"),
            ),
            SearchSettings(speed=number("search_speed"), give_up=number("search_length")),
        )

    def on_odometry(self, message: Message) -> None:
        """Remember where the vehicle was."""
        pose = message.pose.pose
        place = Pose(float(pose.position.x), float(pose.position.y), yaw_of(pose.orientation))
        _keep(self._poses, stamp_of(message.header), place)

    def on_cross_track(self, message: Message) -> None:
        """Remember where the cable was."""
        pose = message.pose.pose
        cable = Cable(float(pose.position.y), yaw_of(pose.orientation))
        _keep(self._cables, stamp_of(message.header), cable)

    def on_state(self, message: Message) -> None:
        """Take note that the tracker has seen a frame, and whether it claims a cable in it."""
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
        is_complete = stamp in self._poses and (stamp in self._cables or not is_claimed)
        if not is_complete and time.monotonic() - came < self._number("settle_time"):
            return
        self._states.pop(0)
        cable = self._cables.get(stamp) if is_claimed else None
        pose = self._poses.get(stamp) or next(reversed(self._poses.values()), None)
        self._publish(self._controller.step(stamp / NANOSECONDS, cable, pose))
        self._stopped = False
        self._tell(stamp)

    def _watch(self) -> None:
        silent = time.monotonic() - self._last_state > self._number("state_timeout")
        if silent and not self._stopped:
            self._stopped = True
            self.get_logger().warning("no `state` comes from the tracker: the vehicle stops")
            self._publish(STOP)

    def _publish(self, command: Command) -> None:
        message = Twist()
        message.linear.x = command.surge
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
        is_well = self.mode is Mode.FOLLOWING
        status = DiagnosticStatus(
            level=DiagnosticStatus.OK if is_well else DiagnosticStatus.WARN,
            name=f"{self.get_fully_qualified_name()}: guidance",
            message=self.mode.value,
            hardware_id=self.get_fully_qualified_name(),
        )
        message.status.append(status)
        self._diagnostics.publish(message)


def _keep(kept: OrderedDict[int, Kept], stamp: int, value: Kept) -> None:
    kept[stamp] = value
    while len(kept) > KEPT:
        kept.popitem(last=False)
