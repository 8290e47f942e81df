"""The closed loop with real processes, over a short way."""

from __future__ import annotations

import csv
import signal
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from sensor_msgs.msg import Image

from cable_tracker.errors import OutputError
from cable_tracker.evaluation.loop_table import SUMMARY, TABLE, LoopSummary
from cable_tracker.ros.rigs.closed_loop.loop import (
    ERRORS,
    VIDEO,
    WAY,
    LoopRequest,
    file_names,
    run_loop,
)
from cable_tracker.simulation.live_world import LiveSettings

FILES = (TABLE, SUMMARY, WAY, ERRORS, VIDEO)
START = {"particle_count": 300}
SHORT = {"length": 1.4, "rate": 5.0}
"""Length of the cable [m] and frames per second of a run that more than one test looks at."""


# A busy machine answers few frames a second, and may halt: neither is to end the run.
SLOWLY = {"speed": 0.2, "standstill": 0.0, "patience": 300.0}


def request(length: float = 2.0, rate: float = 12.5, **changes: Any) -> LoopRequest:
    world = LiveSettings(
        seed=5, length=length, rate=rate, buried=0.0, image_width=160, image_height=120
    )
    usual = LoopRequest(
        world=world, method="default", tracker={"seed": 5, **START}, speed=0.5, realtime=False,
        standstill=15.0, with_video=True,
    )  # fmt: skip
    return replace(usual, **changes)


def run(
    wanted: LoopRequest, folder: Path, *, overwrite: bool = False, ways: list[float] | None = None
) -> LoopSummary:
    return run_loop(
        wanted, folder, overwrite=overwrite, advance=[].append if ways is None else ways.append
    )


def contents(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in FILES}


@dataclass(frozen=True)
class Followed:
    """A run in lockstep."""

    folder: Path
    summary: LoopSummary
    ways: list[float]


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    folder, ways = tmp_path_factory.mktemp("followed") / "loop", []
    return Followed(folder, run(request(**SHORT), folder, ways=ways), ways)


def test_in_lockstep_the_vehicle_follows_the_cable_to_its_end(followed):
    summary = followed.summary
    assert summary.reached_end and not summary.lost_for_good
    assert summary.measured > 0.5 and summary.wrong == 0.0
    with (followed.folder / TABLE).open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == summary.frames == len(followed.ways)
    assert float(rows[-1]["x"]) > float(rows[0]["x"]) + 0.9
    assert all((followed.folder / name).stat().st_size > 0 for name in FILES)


@pytest.mark.slow
def test_in_lockstep_the_same_seed_writes_the_same_files(followed, tmp_path):
    assert run(request(**SHORT), tmp_path / "again") == followed.summary
    assert contents(tmp_path / "again") == contents(followed.folder)


@pytest.mark.slow
def test_in_real_time_the_vehicle_arrives_as_well(tmp_path):
    summary = run(request(realtime=True, **SLOWLY), tmp_path / "live")
    assert summary.reached_end
    assert all((tmp_path / "live" / name).stat().st_size > 0 for name in FILES)


@pytest.mark.slow
def test_a_baseline_takes_the_tracker_s_place(tmp_path):
    wanted = replace(request(method="hough", with_video=False), tracker={"seed": 5})
    summary = run(wanted, tmp_path / "hough")
    assert summary.reached_end and summary.answered == 1.0
    assert summary.measured > 0.5 and summary.wrong == 0.0
    assert {each.name for each in (tmp_path / "hough").iterdir()} == set(file_names(wanted))
    assert VIDEO not in file_names(wanted)


def test_a_folder_that_is_taken_is_refused_before_anything_runs(tmp_path):
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "thesis.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match="exists already"):
        run(request(), tmp_path / "taken")
    with pytest.raises(OutputError, match="no earlier output"):
        run(request(), tmp_path / "taken", overwrite=True)


def test_simulate_live_publishes_until_it_is_stopped(world):
    images = world.listen(Image, "/image")
    command = [sys.executable, "-m", "cable_tracker.cli", "simulate", "--live", "--size", "64x48"]
    with subprocess.Popen(command, stderr=subprocess.PIPE) as process:
        try:
            world.spin(lambda: len(images) >= 3)
            process.send_signal(signal.SIGINT)
            assert process.wait(300.0) == 0
        finally:
            process.kill()
    assert (images[0].width, images[0].height) == (64, 48)
