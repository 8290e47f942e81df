from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.commands.many_runs.loops import NODES_OF_RUN, RUN_GRACE, LoopTask, run_loops
from cable_tracker.ros.process.child_process import GRACE
from cable_tracker.simulation.live_world import LiveSettings

loop = pytest.importorskip("cable_tracker.ros.rigs.closed_loop.loop")

SHORT = ("--length=1", "--buried=0", "--size=160x120", "--no-video")


@pytest.mark.slow
def test_a_failed_run_has_its_reason_and_does_not_end_the_others(tmp_path):
    done: list[bool] = []
    tasks = [LoopTask("hough", seed, SHORT) for seed in (-1, 5)]
    bad, good = run_loops(
        tasks, tmp_path, ClusterSettings(), resume=False, advance=lambda: done.append(True)
    )
    assert (bad.seed, bad.summary) == (-1, None)
    assert bad.failure.startswith("seed: -1 is outside 0")
    assert good.summary is not None and good.summary.seed == 5
    assert good.failure == ""
    assert len(done) == 2


@pytest.mark.slow
def test_a_run_is_another_one_when_its_parameters_were_edited(tmp_path):
    params = tmp_path / "mine.yaml"
    params.write_text("seed: 1\n")
    task = LoopTask("default", 1, (f"--params={params}",), (params,))
    before = task.fingerprint()
    assert task.fingerprint() == before
    params.write_text("seed: 10\n")
    assert task.fingerprint() != before


@pytest.mark.parametrize("method", ["default", "hough"])
def test_a_run_has_time_to_stop_each_of_its_nodes(tmp_path, monkeypatch, method):
    started: list[str] = []
    group = SimpleNamespace(start=lambda name, *_, **__: started.append(name))
    monkeypatch.setattr(loop, "closed_loop", lambda *_: nullcontext((None, None, group)))
    for step in ("wait_until_connected", "follow", "write"):
        monkeypatch.setattr(loop._Run, step, lambda *_: None)
    request = loop.LoopRequest(
        LiveSettings(length=1.0, buried=0.0), method, {}, speed=0.5, realtime=False,
        standstill=15.0, with_video=False,
    )  # fmt: skip
    loop.run_loop(request, tmp_path / "run", overwrite=False, advance=lambda _: None)
    assert len(started) == NODES_OF_RUN
    assert len(started) * GRACE < RUN_GRACE
