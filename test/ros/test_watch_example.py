"""The example in docs/examples that listens to a tracker and sets a parameter."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import pytest


@pytest.fixture
def watcher(world: Any, load_example: Callable[[str], Any]) -> Any:
    module = load_example("watch_tracker.py")
    return world.add(module.WatchTracker(context=world.context, namespace=world.namespace))


def test_the_example_sets_parameters_and_resets(
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


def test_the_example_prints_where_the_cable_is(
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


def test_the_example_prints_that_no_cable_is_claimed(
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
    complaints_after_signal: Callable[..., str], number: signal.Signals
) -> None:
    def wait_until_it_spins(process: Any) -> None:
        assert "waiting for" in process.stdout.readline()

    assert "Traceback" not in complaints_after_signal(
        "watch_tracker.py", number, wait_until_it_spins
    )
