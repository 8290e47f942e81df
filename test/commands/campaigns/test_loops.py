from __future__ import annotations

import pytest

from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.commands.campaigns.loops import LoopTask, run_loops

pytestmark = pytest.mark.slow

pytest.importorskip("rclpy")

SHORT = ("--length=1", "--buried=0", "--size=160x120", "--no-video")


def test_a_run_that_fails_says_why_and_does_not_end_the_others(tmp_path):
    done: list[bool] = []
    tasks = [LoopTask("hough", seed, SHORT) for seed in (-1, 5)]
    bad, good = run_loops(tasks, tmp_path, ClusterSettings(), advance=lambda: done.append(True))
    assert (bad.seed, bad.summary) == (-1, None)
    assert bad.failure.startswith("seed is -1")
    assert good.summary is not None and good.summary.seed == 5
    assert good.failure == ""
    assert len(done) == 2


def test_a_run_is_another_one_when_its_parameters_were_edited(tmp_path):
    params = tmp_path / "mine.yaml"
    params.write_text("seed: 1\n")
    task = LoopTask("default", 1, (f"--params={params}",), (params,))
    before = task.fingerprint()
    assert task.fingerprint() == before
    params.write_text("seed: 10\n")
    assert task.fingerprint() != before
