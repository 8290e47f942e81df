"""The example in docs/examples, as a node and beside the others."""

from __future__ import annotations

import importlib.util
import math
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "follow_cable.py"

PATIENCE = 60.0
"""What has not ended by then does not end [s]."""


@pytest.fixture
def example() -> Any:
    spec = importlib.util.spec_from_file_location("follow_cable", EXAMPLE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


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
def test_it_steers_to_where_the_cable_is_and_stops_without_one(
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
    world: Any, tmp_path: Path, number: signal.Signals
) -> None:
    words = tmp_path / "stderr"
    command = [sys.executable, EXAMPLE, "--ros-args", "-r", f"__ns:={world.namespace}"]
    with words.open("w") as file, subprocess.Popen(command, stderr=file) as process:
        try:
            # Its watchdog speaks when it spins.
            heard = world.listen(Twist, "cmd_vel")
            world.spin(lambda: heard)
            process.send_signal(number)
            process.wait(PATIENCE)
        finally:
            process.kill()
    assert "Traceback" not in words.read_text()


def test_it_is_short() -> None:
    lines = EXAMPLE.read_text(encoding="utf-8").partition("class ")[2].splitlines()
    assert len(lines) <= 30
