from __future__ import annotations

from typing import Any

import pytest
from geometry_msgs.msg import Twist, Vector3

from cable_tracker.errors import RosError
from cable_tracker.ros.process.node_group import NodeGroup
from cable_tracker.ros.rigs.closed_loop import run_recorder
from cable_tracker.ros.rigs.closed_loop.run_recorder import (
    COMMAND,
    QUIET_TURNS,
    RELEASED,
    ReleasedCommands,
    listen_to_the_end,
)


class Run:
    """Recorder, executor and simulator of a run in one: what happens in which turn.

    The simulator ends in turn `end`; a message comes in each turn of `messages`.
    """

    def __init__(self, end: int, messages: tuple[int, ...] = ()) -> None:
        self.turns = self.received = 0
        self._end = end
        self._messages = messages

    def spin_once(self, timeout_sec: float) -> None:
        del timeout_sec
        self.turns += 1
        self.received += self.turns in self._messages

    @property
    def running(self) -> bool:
        return self.turns < self._end

    def take(self) -> list[Any]:
        return []


def listen(run: Any, group: Any = None) -> None:
    listen_to_the_end(
        run,
        run,
        group or NodeGroup("/run"),
        run,
        show=[].append,
        has_settled=lambda _: True,
    )


@pytest.mark.parametrize("last", [5, 5 + QUIET_TURNS])
def test_a_recording_ends_after_many_turns_without_a_message(last):
    run = Run(5, (2, last))
    listen(run)
    assert run.turns == last + QUIET_TURNS


def test_a_simulator_that_has_sent_nothing_for_a_while_has_not_ended():
    run = Run(3 * QUIET_TURNS)
    listen(run)
    assert run.turns == 4 * QUIET_TURNS


def test_a_recording_without_messages_for_too_long_is_an_error(monkeypatch):
    now = [100.0]

    class Slow(Run):
        def spin_once(self, timeout_sec: float) -> None:
            super().spin_once(timeout_sec)
            now[0] += 0.5 * run_recorder.SILENCE_TIMEOUT

    monkeypatch.setattr(run_recorder.time, "monotonic", lambda: now[0])
    run = Slow(9)
    with pytest.raises(RosError, match=r"nothing came for 300 s; is the machine too busy\?"):
        listen(run)
    assert run.turns == 3


def test_a_node_that_has_died_ends_it():
    class Died:
        def what_has_died(self) -> str:
            return "the tracker node has died: nonsense"

    with pytest.raises(RosError, match="tracker node has died: nonsense"):
        listen(Run(9), Died())


@pytest.fixture
def commands(world: Any) -> ReleasedCommands:
    return ReleasedCommands(world.me)


@pytest.fixture
def steer(world: Any, commands: ReleasedCommands) -> Any:
    """Return a function that sends a command of a speed, and waits until it has come."""
    publisher = world.me.create_publisher(Twist, COMMAND, 10)

    def steered(speed: float) -> None:
        before = commands.received
        publisher.publish(Twist(linear=Vector3(x=speed)))
        world.spin(lambda: commands.received > before)

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


def test_released_commands_wait_for_the_simulator_to_listen(world, commands, steer):
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
