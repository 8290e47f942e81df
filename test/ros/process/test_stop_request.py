from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from cable_tracker.ros.process.stop_request import StopRequest, stop_on_signals


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_noted_and_nothing_else_happens(number: int) -> None:
    stop = stop_on_signals()
    assert not stop.requested
    os.kill(os.getpid(), number)
    assert stop.requested


def test_no_stop_is_requested_at_first() -> None:
    assert not StopRequest().requested


def test_the_entry_does_not_import_rclpy() -> None:
    code = "import sys, cable_tracker.ros.entry; sys.exit('rclpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
