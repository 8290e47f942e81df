from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, Range

from cable_tracker.errors import ParameterError, RosError
from cable_tracker.ros.nodes.vehicle_node import TICKS
from cable_tracker.sequences.messages.headers import stamp_of

CURRENT_AHEAD = 2
"""A seed whose current carries the vehicle along the cable."""

SMALL = {"image_width": 64, "image_height": 48, "length": 8.0, "buried": 0.0, "seed": 2}


class Pilot:
    """Steers a simulator in lockstep, and hears all that it says."""

    def __init__(self, world: Any) -> None:
        self._world = world
        self._commands = world.me.create_publisher(Twist, "cmd_vel", 10)
        self.images = world.listen(Image, "image")
        self.infos = world.listen(CameraInfo, "camera_info")
        self.altitudes = world.listen(Range, "altitude")
        self.imus = world.listen(Imu, "imu")
        self.odometry = world.listen(Odometry, "odometry")
        self.true_odometry = world.listen(Odometry, "ground_truth/odometry")
        self.true_cross_tracks = world.listen(PoseWithCovarianceStamped, "ground_truth/cross_track")
        self.true_states = world.listen(JointState, "ground_truth")

    def waits_for(self, count: int) -> None:
        self._world.spin(lambda: len(self.images) >= count)

    def drives(self, surge: float = 0.5, turn: float = 0.0, frames: int = 1) -> None:
        for _ in range(frames):
            count = len(self.images)
            self._world.spin(self._commands.get_subscription_count)
            message = Twist()
            message.linear.x, message.angular.z = surge, turn
            self._commands.publish(message)
            self.waits_for(count + 1)


@pytest.fixture
def pilot(world: Any) -> Pilot:
    return Pilot(world)


@pytest.fixture
def start(world: Any, pilot: Pilot) -> Callable[..., Any]:
    def started(**parameters: Any) -> Any:
        node = world.simulator(**{**SMALL, "lockstep": True, **parameters})
        pilot.waits_for(1)
        return node

    return started


def test_with_a_frame_come_all_instruments_of_its_time(world, start, pilot):
    start()
    heard = (
        pilot.images, pilot.infos, pilot.altitudes, pilot.imus, pilot.odometry,
        pilot.true_odometry, pilot.true_cross_tracks, pilot.true_states,
    )  # fmt: skip
    world.spin(lambda: all(heard))
    assert {stamp_of(messages[0].header) for messages in heard} == {1_000_000_000}


def test_in_lockstep_time_stands_still_until_a_command_comes(world, start, pilot):
    start()
    world.pass_time(0.5)
    assert len(pilot.images) == 1
    pilot.drives()
    world.spin(lambda: len(pilot.odometry) >= 1 + TICKS)
    assert stamp_of(pilot.images[1].header) - stamp_of(pilot.images[0].header) == 80_000_000


def test_the_vehicle_goes_where_it_is_told(world, start, pilot):
    start()
    pilot.drives(surge=0.5, frames=25)
    world.spin(lambda: len(pilot.true_odometry) == 26)
    first, last = (pilot.true_odometry[place].pose.pose.position for place in (0, -1))
    assert math.hypot(last.x - first.x, last.y - first.y) > 0.4
    assert pilot.true_odometry[-1].twist.twist.linear.x > 0.3


def test_odometry_has_a_twist_and_its_covariance(world, start, pilot):
    start()
    pilot.drives(frames=2)
    message = pilot.odometry[-1]
    assert message.header.frame_id == "odom"
    assert message.child_frame_id == "base_link"
    assert all(message.twist.covariance[7 * row] > 0.0 for row in range(6))


def test_commands_that_are_not_finite_count_as_none(world, start, pilot):
    node = start()
    pilot.drives(surge=math.nan, turn=math.inf, frames=5)
    assert node.world.state().twist[0] < 0.2
    assert abs(node.world.state().angles[2]) < math.pi


def test_a_vehicle_that_is_to_stand_still_for_long_ends_the_run(world, start, pilot):
    node = start(standstill=1.0)
    pilot.drives(surge=0.5, frames=5)
    pilot.drives(surge=0.0, frames=12)
    assert not node.finished
    pilot.drives(surge=0.0, frames=1)
    world.spin(lambda: node.finished)


def test_a_vehicle_may_stand_still_where_no_end_is_asked_for(world, start, pilot):
    node = start()
    pilot.drives(surge=0.0, frames=30)
    assert not node.finished


def test_at_the_end_of_the_cable_the_node_has_finished(world, start, pilot):
    node = start(length=1.0)
    while not node.finished:
        pilot.drives()
    assert len(pilot.images) < 100
    assert pilot.true_odometry[-1].pose.pose.position.x >= 0.7


def test_a_vehicle_that_does_not_get_on_is_not_waited_for(world, start, pilot):
    node = start(patience=1.0)
    while not node.finished:
        pilot.drives(surge=0.0)
    assert len(pilot.images) < 30


def test_drift_is_no_progress(world, start, pilot):
    """A current that carries the vehicle along the cable does not keep the run alive."""
    node = start(patience=4.0, current=1.0, seed=CURRENT_AHEAD)
    while not node.finished:
        pilot.drives(surge=0.0)
    assert pilot.true_odometry[-1].pose.pose.position.x > 1.0
    assert node.world.time < 6.0


def test_a_missing_command_ends_the_simulation(world, start, pilot):
    with pytest.raises(RosError, match="no cmd_vel came for frame 0 within"):
        start(answer_timeout=0.2)
        world.spin(lambda: False)


def test_the_simulation_begins_when_enough_nodes_read_images(world, pilot):
    world.simulator(**SMALL, image_readers=2)
    world.pass_time(0.5)
    assert not pilot.images
    world.listen(Image, "image")
    pilot.waits_for(1)


def test_the_simulation_begins_when_enough_nodes_read_the_truth(world, pilot):
    world.simulator(**SMALL, truth_readers=2)
    world.pass_time(0.5)
    assert not pilot.images
    truths = world.listen(PoseWithCovarianceStamped, "ground_truth/cross_track")
    pilot.waits_for(1)
    world.spin(lambda: truths)
    assert stamp_of(truths[0].header) == stamp_of(pilot.images[0].header)


def test_in_real_time_frames_come_without_commands(world, pilot):
    world.simulator(**SMALL)
    pilot.waits_for(5)


def test_in_real_time_the_vehicle_stops_without_commands(world, pilot):
    node = world.simulator(**SMALL, command_timeout=0.3, current=0.0)
    pilot.waits_for(1)
    # On a busy machine it may stop between two commands.
    while node.world.state().twist[0] <= 0.1:
        pilot.drives(surge=0.5)
    world.spin(lambda: node.world.state().twist[0] < 0.05)


def test_the_clock_is_published_on_demand(world, start, pilot):
    clocks = world.listen(Clock, "/clock")
    start(publish_clock=True)
    world.spin(lambda: clocks)
    assert clocks[0].clock.sec == 1


def test_contradictory_settings_are_refused(world):
    with pytest.raises(ParameterError, match="buried is 5"):
        world.simulator(length=2.0)
