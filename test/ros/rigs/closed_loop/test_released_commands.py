from __future__ import annotations

from typing import Any

import pytest
from geometry_msgs.msg import Twist, Vector3

from cable_tracker.ros.rigs.closed_loop.released_commands import COMMAND, RELEASED, ReleasedCommands


@pytest.fixture
def commands(world: Any) -> ReleasedCommands:
    return ReleasedCommands(world.me)


@pytest.fixture
def steer(world: Any, commands: ReleasedCommands) -> Any:
    """Return a function that sends a command of a speed, and waits until it has come."""
    publisher = world.me.create_publisher(Twist, COMMAND, 10)

    def steered(speed: float) -> None:
        before = commands.heard
        publisher.publish(Twist(linear=Vector3(x=speed)))
        world.spin(lambda: commands.heard > before)

    return steered


def speeds(released: list[Twist]) -> list[float]:
    return [command.linear.x for command in released]


def test_a_command_is_held_until_its_frame_is_recorded(world, commands, steer):
    released = world.listen(Twist, RELEASED)
    for speed in (1.0, 2.0, 3.0):
        steer(speed)
    commands.release(0)
    world.empty_queues()
    assert released == []
    commands.release(2)
    world.empty_queues()
    assert speeds(released) == [1.0, 2.0]
    commands.release(2)
    world.empty_queues()
    assert speeds(released) == [1.0, 2.0]
    commands.release(3)
    world.empty_queues()
    assert speeds(released) == [1.0, 2.0, 3.0]


def test_it_waits_for_the_simulator_to_listen(world, commands, steer):
    steer(1.0)
    commands.release(1)
    released = world.listen(Twist, RELEASED)
    commands.release(1)
    world.spin(lambda: speeds(released) == [1.0])


def test_a_frame_that_is_recorded_before_its_command_lets_it_pass(world, commands, steer):
    released = world.listen(Twist, RELEASED)
    commands.release(1)
    steer(1.0)
    commands.release(1)
    world.spin(lambda: speeds(released) == [1.0])
