from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from types import SimpleNamespace

import pytest

if importlib.util.find_spec("rclpy") is None:
    pytest.skip("ROS 2 IS MISSING: the soak test is not tested", allow_module_level=True)

from cable_tracker.commands.dev import soak
from cable_tracker.ros.rigs.soak.record import SoakRecord
from cable_tracker.ros.rigs.soak.rig import SoakSettings
from cable_tracker.ros.rigs.soak.soak import check_settings

pytestmark = pytest.mark.slow


@pytest.fixture
def run(monkeypatch, command):
    """Run the command with a soak test that has happened already."""

    def run_command(record: SoakRecord, *arguments: str):
        done = SimpleNamespace(
            SoakSettings=SoakSettings,
            check_settings=check_settings,
            run_soak=lambda _frames, _settings, _advance: record,
        )
        monkeypatch.setattr(soak, "need_ros", lambda _name: done)
        return command("dev", "soak", "--size", "64x48", *arguments)

    return run_command


def record() -> SoakRecord:
    kept = SoakRecord(sent=3, answered=3, latencies=[(0.0, 5.0)])
    kept.faults["overload"] += 1
    kept.recoveries["overload"] += 1
    return kept


def test_kept_promises_are_exit_code_0(run):
    result = run(record())
    assert result.code == 0
    assert "all promises kept" in result.out
    content = json.loads(Path("soak.json").read_text())
    assert content["faults"] == {"overload": 1}
    assert content["settings"]["preset"] == "default"


def test_a_broken_promise_is_exit_code_1_and_written_down(run):
    broken = record()
    broken.broken("an answer took 2.00 s at 0.1 min")
    result = run(broken)
    assert result.code == 1
    assert "broken promise: an answer took 2.00 s" in result.out
    assert len(json.loads(Path("soak.json").read_text())["broken_promises"]) == 1


def test_an_earlier_report_is_replaced_only_by_force(run):
    assert [run(record(), *words).code for words in ((), (), ("--force",))] == [0, 2, 0]


def test_no_minutes_are_refused(run):
    run(record(), "--minutes", "0").assert_refused("minutes is 0")


@pytest.mark.parametrize("tracker", [(), ("--target",)])
def test_a_size_that_no_picture_has_is_refused(run, tracker):
    run(record(), *tracker, "--size", "0x0").assert_refused("image_size is 0x0")
