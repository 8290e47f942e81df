"""The example in docs/examples that listens to a tracker and sets a parameter."""

from __future__ import annotations

import importlib.util
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "watch_tracker.py"

PATIENCE = 60.0
"""What has not ended by then does not end [s]."""


@pytest.fixture
def watcher(world: Any) -> Any:
    spec = importlib.util.spec_from_file_location("watch_tracker", EXAMPLE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return world.add(module.WatchTracker(context=world.context, namespace=world.namespace))


def test_it_sets_parameters_and_resets(
    world: Any, watcher: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    tracker = world.tracker()
    world.spin(watcher.parameters.services_are_ready)
    printed: list[str] = []

    def heard(words: str) -> bool:
        printed.append(capsys.readouterr().out)
        return words in "".join(printed)

    watcher.set("particle_count", 80)
    world.spin(lambda: heard("taken"))
    assert tracker.get_parameter("particle_count").value == 80
    watcher.set("particle_count", 0)
    world.spin(lambda: heard("refused: "))
    world.spin(watcher.reset.service_is_ready)
    answer = watcher.reset.call_async(watcher.reset.srv_type.Request())
    world.spin(answer.done)
    assert answer.result().success


def test_it_prints_where_the_cable_is(
    world: Any,
    watcher: Any,
    near: str,
    image_message: Callable[..., Any],
    capsys: pytest.CaptureFixture[str],
) -> None:
    tracker = world.tracker(initial_state=near)
    world.spin(lambda: world.me.count_subscribers(f"{world.namespace}/centreline"))
    world.show(tracker, image_message())
    printed: list[str] = []

    def heard() -> bool:
        printed.append(capsys.readouterr().out)
        return "centreline: x" in "".join(printed) and "state: d" in "".join(printed)

    world.spin(heard, patience=60.0)


def test_it_says_that_no_cable_is_claimed(
    world: Any,
    watcher: Any,
    image_message: Callable[..., Any],
    capsys: pytest.CaptureFixture[str],
) -> None:
    tracker = world.tracker()
    world.spin(lambda: world.me.count_subscribers(f"{world.namespace}/state"))
    world.show(tracker, image_message())
    world.spin(lambda: "no cable is claimed" in capsys.readouterr().out, patience=60.0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_without_a_traceback(
    world: Any, tmp_path: Path, number: signal.Signals
) -> None:
    words = tmp_path / "stderr"
    command = [sys.executable, EXAMPLE, "--ros-args", "-r", f"__ns:={world.namespace}"]
    with (
        words.open("w") as file,
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=file, text=True) as process,
    ):
        try:
            assert process.stdout is not None
            assert "waiting for" in process.stdout.readline()
            process.send_signal(number)
            process.wait(PATIENCE)
        finally:
            process.kill()
    assert "Traceback" not in words.read_text()
