"""SIGINT and SIGTERM reach a command wherever they come up, and its clean-up is left in peace."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

BEGIN = """
import ctypes, signal, time
from cable_tracker.commands.console.stop_signals import CHECK_INTERVAL, Stopped, StopSignals

class Destroyed:
    def __del__(self):
        signal.raise_signal(NUMBER)

def called_by_c():
    signal.raise_signal(NUMBER)

signals = StopSignals()
signals.install()
"""

DROPPED = {
    "a destructor": "del_me = Destroyed(); del del_me",
    "a callback of C": "ctypes.CFUNCTYPE(None)(called_by_c)()",
}
"""Places from which an exception does not come out."""


def run(code: str, number: signal.Signals) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", BEGIN.replace("NUMBER", str(number.value)) + code],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("place", DROPPED)
def test_a_stop_that_is_dropped_comes_again(place, number):
    code = f"""
try:
    {DROPPED[place]}
    print("dropped")
    time.sleep(300)
except Stopped as stopped:
    signals.arrived()
    print(stopped.exit_code)
"""
    ended = run(code, number)
    assert ended.stdout.split() == ["dropped", str(128 + number)]
    assert not ended.stderr


def test_a_clean_up_is_not_stopped_again():
    code = """
try:
    try:
        signal.raise_signal(signal.SIGINT)
    finally:
        time.sleep(3 * CHECK_INTERVAL)
        print("cleaned")
except Stopped:
    signals.arrived()
    time.sleep(3 * CHECK_INTERVAL)
    print("arrived")
"""
    ended = run(code, signal.SIGINT)
    assert ended.stdout.split() == ["cleaned", "arrived"]
    assert ended.returncode == 0


def test_an_object_interrupted_in_its_construction_prints_nothing():
    code = """
class HalfMade:
    def __init__(self):
        signal.raise_signal(signal.SIGINT)
        self.made = True
    def __del__(self):
        print(self.made)

try:
    HalfMade()
except Stopped:
    signals.arrived()
"""
    ended = run(code, signal.SIGINT)
    assert not ended.stderr
    assert ended.returncode == 0


def test_without_a_signal_what_cannot_be_raised_is_reported():
    code = """
class Bad:
    def __del__(self):
        raise ValueError("a fault of the program")

Bad()
"""
    assert "a fault of the program" in run(code, signal.SIGINT).stderr
