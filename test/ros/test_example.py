"""The example in docs/examples, as a node and beside the others."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "follow_cable.py"


@pytest.fixture
def example(load_example: Callable[[str], Any]) -> Any:
    return load_example("follow_cable.py")


@pytest.fixture
def commands(world: Any) -> list[Any]:
    return world.listen(Twist, "cmd_vel")


def says(publisher: Any, offset: float, heading: float) -> None:
    message = PoseWithCovarianceStamped()
    message.pose.pose.position.y = offset
    message.pose.pose.orientation.z = math.sin(heading / 2)
    message.pose.pose.orientation.w = math.cos(heading / 2)
    publisher.publish(message)


@pytest.mark.parametrize(("offset", "heading"), [(0.4, 0.0), (0.0, 0.3)])
def test_the_example_steers_towards_the_cable_and_stops_without_one(
    world: Any, example: Any, commands: list[Any], offset: float, heading: float
) -> None:
    world.add(example.FollowCable(context=world.context, namespace=world.namespace))
    publisher = world.me.create_publisher(PoseWithCovarianceStamped, "cross_track", 10)
    world.spin(publisher.get_subscription_count)
    says(publisher, offset, heading)
    world.spin(lambda: any(command.linear.x > 0.3 for command in commands))
    assert max(command.angular.z for command in commands) > 0.1
    world.spin(lambda: commands[-1].linear.x == 0.0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_without_a_traceback(
    world: Any, complaints_after_signal: Callable[..., str], number: signal.Signals
) -> None:
    def wait_until_it_spins(_process: Any) -> None:
        # Its watchdog speaks when it spins.
        heard = world.listen(Twist, "cmd_vel")
        world.spin(lambda: heard)

    assert "Traceback" not in complaints_after_signal(
        "follow_cable.py", number, wait_until_it_spins
    )


def test_the_example_takes_at_most_thirty_lines() -> None:
    lines = EXAMPLE.read_text(encoding="utf-8").partition("class ")[2].splitlines()
    assert len(lines) <= 30
