"""A soak test in small: real processes, rare faults, and a tracker that breaks a promise."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cable_tracker.errors import FrameError, ParameterError
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.ros.rigs.soak import rig as soak_rig
from cable_tracker.ros.rigs.soak import soak
from cable_tracker.ros.rigs.soak.faults import Fault
from cable_tracker.ros.rigs.soak.rig import SoakSettings
from cable_tracker.ros.rigs.soak.soak import check_settings, run_soak
from cable_tracker.ros.rigs.soak.soaked_node import TARGET_NODE
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.target import read_start
from cable_tracker.simulation.targets.sequence import labelled_frames, simulate_target

pytestmark = pytest.mark.slow

FEW_FRAMES = 400
SETTINGS = SoakSettings(
    minutes=600.0, seed=1, fault_share=0.1, frames=FEW_FRAMES, preset="thesis", particles=50,
    node="tracker",
)  # fmt: skip


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """How long an answer takes says how busy the machine is; that it comes is the promise."""
    monkeypatch.setattr(soak_rig, "LONGEST_ANSWER", 300.0)
    monkeypatch.setattr(soak_rig, "PATIENCE", 300.0)


@pytest.fixture
def frames(dive_frames: Any) -> list[Any]:
    return list(dive_frames(12, (64, 48)))


def test_a_tracker_keeps_its_promises(frames):
    shares: list[float] = []
    record = run_soak(frames, SETTINGS, shares.append)
    assert record.breaches == []
    assert record.answered >= FEW_FRAMES
    assert record.recoveries == record.faults
    assert record.faults.total() > 10
    assert record.messages["state"] == record.answered
    assert record.messages["tracker/frame_report"] > 0
    assert min(sample.private for sample in record.memory) > 1.0
    assert all(0.0 <= share < 1.0 for share in shares)


def test_a_target_tracker_keeps_its_promises():
    simulated = simulate_target("leaving", 1, 12, size=(80, 60))
    frames = [frame for frame, _ in labelled_frames(simulated)]
    settings = replace(SETTINGS, node="target_tracker", preset="default", frames=200)
    record = run_soak(frames, settings, lambda share: None)
    assert record.breaches == []
    assert record.recoveries == record.faults
    assert record.faults.total() > 5
    assert record.messages["target_tracker/frame_report"] > 0


def test_marks_that_are_spoilt_are_no_marks():
    factory, rng = RclpyMessages(), np.random.default_rng(1)
    header = make_header(factory, 1, "camera")
    refused = 0
    for _ in range(40):
        mark = TARGET_NODE.bad_start(header, rng)
        with suppress(FrameError):
            read_start(mark).check((80, 60))
            continue
        refused += 1
    assert refused > 20


RARE = [
    Fault.TRACKER_KILLED, Fault.REPLAY_KILLED, Fault.INPUT_STOPS, Fault.FROZEN, Fault.QOS,
    Fault.PARAMETERS, Fault.VIEWER, Fault.OVERLOAD,
]  # fmt: skip


def test_every_rare_fault_is_survived(frames, monkeypatch):
    left = list(RARE)
    monkeypatch.setattr(
        soak, "draw_fault", lambda _rng, possible: left.pop() if left else min(possible)
    )
    settings = replace(SETTINGS, seed=2, fault_share=0.2)
    monkeypatch.setattr(soak, "FULL_RATE_SHARE", 0.0)
    record = run_soak(frames, settings, lambda share: None)
    assert left == []
    assert record.breaches == []
    assert {fault.value for fault in RARE} <= set(record.recoveries)
    assert max(sample.process for sample in record.memory) >= 1


@pytest.mark.parametrize("changes", [{"minutes": 0.0}, {"minutes": math.nan}, {"fault_share": 1.5}])
def test_settings_out_of_range_are_refused(changes):
    with pytest.raises(ParameterError):
        check_settings(replace(SETTINGS, **changes))
