"""With several processes: test_cluster.py."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass

import cv2
import pytest

from cable_tracker.campaigns.runner import run_all
from cable_tracker.campaigns.settings import CampaignSettings, ClusterSettings
from cable_tracker.errors import ParameterError, ResourceError


@dataclass(frozen=True)
class Doubling:
    number: int

    def run(self, advance):
        advance(1)
        return 2 * self.number, cv2.getNumThreads()


class Failing:
    def run(self, advance):
        raise ParameterError("a task that fails")


def test_results_come_in_the_order_of_the_tasks():
    told = []
    results = run_all([Doubling(n) for n in range(5)], advance=told.append)
    # What is measured must not depend on the processors: OpenCV has one.
    assert results == [(2 * n, 1) for n in range(5)]
    assert sum(told) == 5


def test_opencv_has_its_threads_back():
    before = cv2.getNumThreads()
    run_all([Doubling(1)])
    assert cv2.getNumThreads() == before


def test_what_stops_a_task_reaches_the_caller():
    with pytest.raises(ParameterError, match="a task that fails"):
        run_all([Failing(), Failing()])


def test_several_workers_without_dask_are_refused_with_what_to_do(monkeypatch):
    monkeypatch.delitem(sys.modules, "cable_tracker.campaigns.cluster", raising=False)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ResourceError, match="pip install dask distributed"):
        run_all([Doubling(1), Doubling(2)], CampaignSettings(ClusterSettings(2)))


def test_one_worker_needs_no_dask(tmp_path):
    program = (
        "import sys\n"
        "sys.modules.update(dict.fromkeys(('dask', 'distributed')))\n"
        "from pathlib import Path\n"
        "from cable_tracker.campaigns.settings import ClusterSettings\n"
        "from cable_tracker.commands.many_runs.loops import run_loops\n"
        "import cable_tracker.survey.campaign\n"
        "print(run_loops([], Path(sys.argv[1]), ClusterSettings(), resume=False, advance=print))\n"
    )
    said = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert said.stdout == "[]\n"
