"""Base of the simulator nodes: `cmd_vel` in, a vehicle's camera and instruments out."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from cable_tracker.errors import RosError
from cable_tracker.node_parameter_tables import VehicleNodeParameters
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.endpoints import POLL_PERIOD, LastMessages, publisher, subscription
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.process.process_node import WAKE_UP, ProcessNode
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.frame import RawImage
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header, make_time
from cable_tracker.sequences.messages.images import make_image
from cable_tracker.simulation.instruments.instrument_messages import (
    BASE,
    CAMERA,
    ODOM,
    make_camera_info,
    make_imu,
    make_odometry,
    make_true_odometry,
)
from cable_tracker.simulation.live_world import LiveWorld
from cable_tracker.simulation.targets.chase import ChaseWorld
from cable_tracker.simulation.vehicle import VehicleState, VelocityCommand
from cable_tracker.stamps import FIRST_STAMP, NANOSECONDS
from cable_tracker.tracking.parameter_table import Parameters

TICKS = 2
"""Readings of odometry and imu for each frame."""

World = TypeVar("World", bound=LiveWorld | ChaseWorld)
OwnParameters = TypeVar("OwnParameters", bound=VehicleNodeParameters)


class VehicleNode(ProcessNode, ABC, Generic[World, OwnParameters]):
    """Lets a vehicle move as it is told, in real time or in lockstep with what tells it.

    Holds what does not depend on the world: commands, time, odometry and imu. A subclass adds
    its abstract methods.

    Parameters
    ----------
    name : str
        Name of the node.
    make_world : callable
        Makes the world, given its settings.
    settings : ParameterSet
        Default settings of the world.
    parameters : VehicleNodeParameters
        Default parameters of the node beside them.
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter is not acceptable.
    """

    def __init__(
        self,
        name: str,
        make_world: Callable[[Parameters], World],
        settings: Parameters,
        parameters: OwnParameters,
        **node_arguments: Any,  # noqa: ANN401
    ) -> None:
        super().__init__(name, **node_arguments)
        settings = node_parameters.declare_set(self, settings, read_only=True)
        self._own = node_parameters.declare_set(self, parameters, read_only=True)
        node_parameters.warn_of_unknown_overrides(self)
        self._world = make_world(settings)
        self._altitude = self._world.settings.altitude
        self._command = VelocityCommand()
        self._command_time = -math.inf
        self._awaits_command = False
        self._last: LastMessages | None = None
        self._deadline = 0.0
        self._tick = 0
        self._begun = False
        self._first_stamp = FIRST_STAMP
        self._due = 0.0
        self._create_topics()
        self.get_logger().info(f"waiting for a subscriber of {self._image.topic_name}")

    def _publish_altitude(self, stamp: int) -> None:
        """Publish what the altimeter reads at a frame, if the vehicle has one."""
        return

    @abstractmethod
    def _publish_truth(self, state: VehicleState, stamp: int) -> None:
        """Publish what is true at a frame."""

    @abstractmethod
    def _draw(self, state: VehicleState) -> RawImage:
        """Return what the camera sees."""

    @abstractmethod
    def _is_at_end(self, state: VehicleState) -> bool:
        """Tell whether a frame is the last."""

    def _create_topics(self) -> None:
        self._image = publisher(self, node_topics.IMAGE, qos.PICTURES)
        self._info = publisher(self, node_topics.CAMERA_INFO, qos.RESULTS)
        self._imu = publisher(self, node_topics.IMU, qos.RESULTS)
        self._odometry = publisher(self, node_topics.ODOMETRY, qos.RESULTS)
        self._true_odometry = publisher(self, node_topics.TRUE_ODOMETRY, qos.RESULTS)
        self._clock_publisher = None
        if self._own.publish_clock:
            self._clock_publisher = publisher(
                self, node_topics.CLOCK, qos.RESULTS, name=node_topics.CLOCK.global_name
            )
        subscription(self, node_topics.COMMAND, self.on_command, qos.RESULTS)

    @property
    def frames(self) -> int:
        """How many frames have been sent."""
        return (self._tick + TICKS - 1) // TICKS

    def on_command(self, message: Message) -> None:
        """Take a velocity through the water; what is not finite counts as 0."""
        numbers = (message.linear.x, message.linear.y, message.linear.z, message.angular.z)
        self._command = VelocityCommand(
            *(float(value) if math.isfinite(value) else 0.0 for value in numbers)
        )
        self._command_time = time.monotonic()
        self._awaits_command = False

    def seconds_until_due(self) -> float:
        """Return how long the executor may sleep [s]."""
        if self._last is not None:
            return POLL_PERIOD
        if not self._begun or self._awaits_command:
            return WAKE_UP
        return 0.0 if self._own.lockstep else self._due - time.monotonic()

    def work(self) -> None:
        """Let the vehicle go on when it is time, and tell what its instruments say."""
        if not self._begun:
            self._begin()
            return
        if self._last is not None:
            self.finished = self._last.have_arrived()
            return
        if self._awaits_command:
            self._check_deadline()
            return
        if not self._own.lockstep and time.monotonic() < self._due:
            return
        self._go_on()

    def _begin(self) -> None:
        readers = (
            (self._image, self._own.image_readers),
            (self._odometry, self._own.odometry_readers),
            *((each, self._own.truth_readers) for each in self._last_publishers()),
        )
        if any(each.get_subscription_count() < count for each, count in readers):
            return
        self._begun = True
        self._due = time.monotonic()
        if not self._own.lockstep:
            self._first_stamp = int(self.get_clock().now().nanoseconds)

    def _check_deadline(self) -> None:
        if time.monotonic() > self._deadline:
            raise RosError(
                f"no cmd_vel came for frame {self.frames - 1} within"
                f" {self._own.answer_timeout:g} s; are tracker and controller running?"
            )

    def _go_on(self) -> None:
        """Move on by one tick, and publish what is due at its end."""
        period = 1.0 / (TICKS * self._world.settings.rate)
        passed = 0.0
        if self._tick:
            passed = period
            self._world.advance(self._current_command(), self._altitude, period)
        stamp = self._first_stamp + round(self._tick * period * NANOSECONDS)
        state = self._world.state()
        self._publish_readings(state, stamp, passed)
        if self._tick % TICKS == 0:
            self._publish_frame(state, stamp)
        self._tick += 1
        # A machine that is too slow makes time pass more slowly; frames do not pile up.
        self._due = max(self._due + period, time.monotonic() - period)

    def _current_command(self) -> VelocityCommand:
        is_old = time.monotonic() - self._command_time > self._own.command_timeout
        return VelocityCommand() if is_old and not self._own.lockstep else self._command

    def _publish_readings(self, state: VehicleState, stamp: int, passed: float) -> None:
        instruments = self._world.instruments
        if self._clock_publisher is not None:
            self._clock_publisher.publish(Clock(clock=make_time(MESSAGES, stamp)))
        in_odom = make_header(MESSAGES, stamp, ODOM)
        self._odometry.publish(
            make_odometry(MESSAGES, in_odom, instruments.odometry(state, passed))
        )
        header = make_header(MESSAGES, stamp, BASE)
        self._imu.publish(make_imu(MESSAGES, header, instruments.imu(state), instruments.errors))

    def _publish_frame(self, state: VehicleState, stamp: int) -> None:
        self._altitude = self._world.instruments.altitude(state)
        camera_header = make_header(MESSAGES, stamp, CAMERA)
        self._info.publish(make_camera_info(MESSAGES, camera_header, self._world.camera))
        in_odom = make_header(MESSAGES, stamp, ODOM)
        self._true_odometry.publish(make_true_odometry(MESSAGES, in_odom, state))
        picture = self._draw(state)
        self._publish_altitude(stamp)
        self._publish_truth(state, stamp)
        is_at_end = self._is_at_end(state)
        self._awaits_command = self._own.lockstep and not is_at_end
        self._deadline = time.monotonic() + self._own.answer_timeout
        self._image.publish(make_image(MESSAGES, picture, camera_header))
        if is_at_end:
            ending = (self._image, self._true_odometry, *self._last_publishers())
            self._last = LastMessages(ending)
            self.get_logger().info(f"the way is at its end after {self._world.time:.1f} s")

    def _last_publishers(self) -> tuple[Publisher, ...]:
        """Return further publishers whose last message must arrive before the node ends."""
        return ()
