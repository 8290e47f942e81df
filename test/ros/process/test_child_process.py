from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import pytest

from cable_tracker.ros.process import child_process
from cable_tracker.ros.process.child_process import NodeProcess
from cable_tracker.ros.process.environment import local_environment


@pytest.fixture
def process(namespace: str) -> Callable[..., NodeProcess]:
    def make(node: str, *arguments: str) -> NodeProcess:
        return NodeProcess(node, ["-r", f"__ns:={namespace}", *arguments], local_environment())

    return make


def test_a_node_runs_and_is_stopped_at_the_end(
    process: Callable[..., NodeProcess],
    world: Any,
    namespace: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(child_process, "GRACE", 300.0)
    with process("tracker") as tracker:
        world.spin(lambda: ("tracker", namespace) in world.me.get_node_names_and_namespaces())
        assert tracker.running
        assert tracker.wait(0.01) is None
        assert tracker.stop() == 0
        assert not tracker.running
        assert tracker.stop() == 0


def test_the_node_is_stopped_also_after_an_error(process: Callable[..., NodeProcess]) -> None:
    with pytest.raises(ZeroDivisionError), process("tracker") as tracker:
        raise ZeroDivisionError
    assert not tracker.running


def test_the_last_words_of_a_node_that_has_died_can_be_read(
    process: Callable[..., NodeProcess], stand_in: Callable[[str], None]
) -> None:
    stand_in(
        "import sys\n"
        "print('reads', sys.argv[-1])\n"
        "print('error: there is no such file', file=sys.stderr)\n"
        "sys.exit(2)\n"
    )
    with process("replay", "-p", "source:=/missing.mcap") as replay:
        assert replay.wait(300.0) == 2
        assert replay.last_line() == "error: there is no such file"


def test_a_node_without_output_is_reported_as_such(process: Callable[..., NodeProcess]) -> None:
    with process("tracker") as tracker:
        assert tracker.last_line() == "it printed nothing"


def test_a_node_that_does_not_end_is_killed(
    process: Callable[..., NodeProcess],
    stand_in: Callable[[str], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Deaf to all signals but SIGKILL.
    stand_in(
        "import signal, time\n"
        "signal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
        "print('deaf', flush=True)\n"
        "time.sleep(3600)\n"
    )
    monkeypatch.setattr(child_process, "GRACE", 0.2)
    with process("tracker") as deaf:
        while deaf.last_line() != "deaf":
            assert deaf.wait(0.05) is None
        assert deaf.stop() == -9


def test_a_node_without_handlers_yet_is_stopped_also_where_its_parent_ignores_interrupts(
    process: Callable[..., NodeProcess],
    stand_in: Callable[[str], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stand_in("import time\nprint('importing', flush=True)\ntime.sleep(3600)\n")
    monkeypatch.setattr(child_process, "GRACE", 5.0)
    former = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with process("tracker") as importing:
            while importing.last_line() != "importing":
                assert importing.wait(0.05) is None
            assert importing.stop() == -signal.SIGTERM
    finally:
        signal.signal(signal.SIGINT, former)
