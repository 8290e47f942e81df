"""Common base of the example controllers: results of a tracker in, `cmd_vel` out."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import OrderedDict
from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar, Generic, TypeVar

from geometry_msgs.msg import Twist
from rclpy.duration import Duration

from cable_tracker.example_controller.command import STOP, Command
from cable_tracker.node_parameter_tables import GuidanceNodeParameters
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.health.diagnostics import FROZEN_INPUT, Level
from cable_tracker.ros.messages.announced_topics import announced_topics
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.process.process_node import WAKE_UP, ProcessNode
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import make_status_array, report_status
from cable_tracker.sequences.messages.headers import is_representable, make_header, stamp_of
from cable_tracker.sequences.node_topics import TrackerTopics
from cable_tracker.tracking.parameter_table import ParameterSet
from cable_tracker.tracking.status import DISABLED, REFUSED, WARMING_UP
from cable_tracker.tracking.succession import is_out_of_order

Kept = TypeVar("Kept")
Settings = TypeVar("Settings", bound=ParameterSet)

KEPT = 100
"""Messages of each kind that are kept until their `state` comes."""

NO_STATE = "NO STATE"
"""What diagnostics say while no `state` comes."""

IDLE_STATUSES = {DISABLED, WARMING_UP, FROZEN_INPUT}
"""Statuses of a tracker that processes no frame."""

STOP_PATIENCE = 1.0
"""Longest time for the last command to arrive when the node ends [s]."""

REPORT_PATIENCE = 3.0
"""Without a report for so long after the first `state` it is warned of [s]."""

POLL = 0.005
"""Longest sleep while a `state` waits for what belongs to it [s]."""


@dataclass(frozen=True, slots=True)
class Reported:
    """What the tracker's report says of a frame.

    Attributes
    ----------
    has_position : bool
        Whether a position in metres comes with it.
    is_refused : bool
        Whether it could not be used.
    """

    has_position: bool
    is_refused: bool


UNREPORTED = Reported(has_position=True, is_refused=False)
"""Assumed of a frame whose report has not come."""


class GuidanceNode(ProcessNode, ABC, Generic[Settings]):
    """Answers each `state` of a tracker with a `cmd_vel`, and reports its mode.

    Without a `state` for `state_timeout` the vehicle is stopped (one of a time that no message has
    room for counts as none), and so it is while the tracker says that it processes no frame
    (switched off, warming up, or before a picture that stands still), or has refused every frame
    for `state_timeout`; but not in lockstep. In lockstep it waits, at most `settle_time`, until
    every message that the frame report announces has arrived, so that the command does not depend
    on the order of messages. The first command waits until it has a subscriber.

    Parameters
    ----------
    name : str
        Name of the node.
    settings : ParameterSet
        Default settings of its controller.
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter is not acceptable.
    """

    NOMINAL_MODE: ClassVar[Enum]
    """Mode of normal operation, which diagnostics report as OK; any other mode is a warning."""

    TOPICS: ClassVar[TrackerTopics]
    """Topics of the tracker."""

    def __init__(
        self,
        name: str,
        settings: Settings,
        **node_arguments: Any,  # noqa: ANN401
    ) -> None:
        super().__init__(name, **node_arguments)
        self._settings = node_parameters.declare_set(self, settings, read_only=True)
        self._own = node_parameters.declare_set(self, GuidanceNodeParameters(), read_only=True)
        node_parameters.warn_of_unknown_overrides(self)
        self._reported_mode: str | None = None
        self._states: list[tuple[int, bool, float]] = []
        self._last_state = time.monotonic()
        self._last_command = STOP
        self._commands = publisher(self, node_topics.COMMAND, qos.RESULTS)
        self._diagnostics = publisher(
            self, node_topics.DIAGNOSTICS, qos.RESULTS, name=node_topics.DIAGNOSTICS.global_name
        )
        self._reports: OrderedDict[int, Reported] = OrderedDict()
        self._last_processed: int | None = None
        self._status = ""
        self._last_accepted = time.monotonic()
        self._awaits_report_since: float | None = None
        self._is_report_missed = False
        # Before what a subclass subscribes to: a tracker that knows of that knows of this.
        subscription(self, self.TOPICS.report, self.on_report, qos.RESULTS)
        subscription(self, node_topics.STATE, self.on_state, qos.RESULTS)

    @property
    @abstractmethod
    def mode(self) -> Enum:
        """Mode of the node, as diagnostics show it."""

    @abstractmethod
    def _is_complete(self, stamp: int, has_position: bool) -> bool:
        """Tell whether all has come that belongs to a frame of a time [ns].

        Parameters
        ----------
        stamp : int
            The time.
        has_position : bool
            Whether a position in metres belongs to it, as far as is known.
        """

    @abstractmethod
    def _command(self, stamp: int, is_claimed: bool, is_processed: bool) -> Command:
        """Return the answer to a frame.

        Parameters
        ----------
        stamp : int
            Its time [ns].
        is_claimed : bool
            Whether the tracker claims something in it.
        is_processed : bool
            Whether the tracker has processed it; False for one that it has refused.
        """

    def on_state(self, message: Message) -> None:
        """Queue a frame of the tracker to be answered, with whether something is claimed in it."""
        now = time.monotonic()
        stamp = stamp_of(message.header)
        # No message could bear another time, and the tracker has refused such a frame. No command
        # answers it: it counts as silence.
        if is_representable(stamp):
            self._last_state = now
            self._states.append((stamp, bool(message.position), now))
        if not self._own.lockstep:
            self._warn_of_missing_reports(now)

    def _warn_of_missing_reports(self, now: float) -> None:
        """Warn once if `state` has come for a while, up to `now` [s], and never a report."""
        if self._awaits_report_since is None:
            self._awaits_report_since = now
        waited = now - self._awaits_report_since
        if self._reports or self._is_report_missed or waited <= REPORT_PATIENCE:
            return
        self._is_report_missed = True
        topic = self.TOPICS.report.name
        self.get_logger().warning(
            f"`state` comes from the tracker, but nothing comes on"
            f" {self.resolve_topic_name(topic)}: the vehicle would not stop for a camera"
            f" that hangs, nor while the tracker is switched off; remap {topic} to the"
            " tracker's ~/frame_report"
        )

    def on_report(self, message: Message) -> None:
        """Keep the tracker's status, and whether a position in metres comes with a `state`."""
        stamp = stamp_of(message.header)
        has_position = bool(message.status) and self.TOPICS.pose in announced_topics(
            self.TOPICS, message
        )
        self._status = report_status(message) if message.status else ""
        is_refused = self._status == REFUSED
        # A frame that comes twice is refused the second time; what came with the first still does.
        if not (is_refused and stamp in self._reports):
            keep(self._reports, stamp, Reported(has_position, is_refused))
        if not is_refused:
            self._last_accepted = time.monotonic()

    def _is_processed(self, stamp: int, is_claimed: bool) -> bool:
        """Tell whether the tracker has processed a frame of a time [ns]; else it has refused it."""
        if is_claimed:
            return True
        # The times tell it also of a frame that comes twice: its report is that of the first.
        is_late = self._last_processed is not None and is_out_of_order(self._last_processed, stamp)
        return not (is_late or self._reports.get(stamp, UNREPORTED).is_refused)

    def _idle_status(self) -> str:
        """Return the tracker's status while it processes no frame; empty: it does."""
        # A refused frame among others is passed over; of refused ones alone a vehicle that follows
        # or searches would learn nothing.
        blind_for = time.monotonic() - self._last_accepted if self._status == REFUSED else 0.0
        is_idle = self._status in IDLE_STATUSES or blind_for > self._own.state_timeout
        return self._status if is_idle else ""

    def seconds_until_due(self) -> float:
        """Return how long the executor may sleep [s]."""
        return POLL if self._states else WAKE_UP

    def work(self) -> None:
        """Answer the oldest `state`, or stop the vehicle if none comes."""
        if self._states:
            self._answer(*self._states[0])
        elif not self._own.lockstep:
            self._stop_if_silent()

    def _answer(self, stamp: int, is_claimed: bool, came: float) -> None:
        # A first command without a subscriber would stop a lockstep simulator for ever.
        if self._own.lockstep and not self._commands.get_subscription_count():
            return
        idle = "" if self._own.lockstep else self._idle_status()
        if idle:
            self._states.pop(0)
            self._stop_while_idle(stamp, idle)
            return
        has_time = time.monotonic() - came < self._own.settle_time
        has_position = is_claimed and self._reports.get(stamp, UNREPORTED).has_position
        if has_time and not self._is_complete(stamp, has_position):
            return
        self._states.pop(0)
        is_processed = self._is_processed(stamp, is_claimed)
        if is_processed:
            self._last_processed = stamp
        command = self._command(stamp, is_claimed, is_processed)
        # Before the command: in lockstep, all about a frame is published when the next one comes.
        self._report_mode_change(stamp)
        self._send(command)

    def _stop_while_idle(self, stamp: int, status: str) -> None:
        """Let the vehicle stop: to search makes no sense while the tracker processes no frame."""
        self._stop()
        if self._note_mode(status):
            self.get_logger().warning(f"the tracker says {status}: the vehicle stops")
            self._report(stamp, status, Level.WARN)

    def _stop_if_silent(self) -> None:
        is_silent = time.monotonic() - self._last_state > self._own.state_timeout
        if is_silent and self._note_mode(NO_STATE):
            is_moving = self._stop()
            self.get_logger().warning(
                "no `state` comes from the tracker" + (": the vehicle stops" if is_moving else "")
            )
            self._report(int(self.get_clock().now().nanoseconds), NO_STATE, Level.WARN)

    def _note_mode(self, mode: str) -> bool:
        """Keep a mode as the last one reported; tell whether it differs from the one before."""
        before, self._reported_mode = self._reported_mode, mode
        return mode != before

    def _stop(self) -> bool:
        """Let the vehicle stop if a command lets it move; tell whether one did."""
        if self._last_command == STOP:
            return False
        self._send(STOP)
        return True

    def _send(self, command: Command) -> None:
        self._last_command = command
        message = Twist()
        message.linear.x, message.linear.z = command.surge, command.heave
        message.angular.z = command.turn
        self._commands.publish(message)

    def _report_mode_change(self, stamp: int) -> None:
        """Report a change of mode in the log and in diagnostics."""
        if self._note_mode(self.mode.value):
            self.get_logger().info(self.mode.value)
            level = Level.OK if self.mode is self.NOMINAL_MODE else Level.WARN
            self._report(stamp, self.mode.value, level)

    def _report(self, stamp: int, mode: str, level: Level) -> None:
        """Publish a diagnostics message of a time [ns]."""
        name = str(self.get_fully_qualified_name())
        message = make_status_array(
            MESSAGES,
            make_header(MESSAGES, stamp, ""),
            f"{name}: guidance",
            mode,
            {},
            level=level,
            hardware_id=name,
        )
        self._diagnostics.publish(message)

    def destroy_node(self) -> None:
        """Let the vehicle stop, and destroy the node: nothing would stop it afterwards."""
        if self.context.ok() and not self._own.lockstep and self._stop():
            # The publisher must not be gone before its last message is.
            self._commands.wait_for_all_acked(Duration(seconds=STOP_PATIENCE))
        super().destroy_node()


def keep(kept: OrderedDict[int, Kept], stamp: int, value: Kept) -> None:
    """Keep a value by its time [ns], and as many as `KEPT` of those before it."""
    kept[stamp] = value
    while len(kept) > KEPT:
        kept.popitem(last=False)
