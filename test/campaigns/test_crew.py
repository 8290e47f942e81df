"""With several processes: test_runner.py."""

from __future__ import annotations

import os
import pickle
import sys
from dataclasses import dataclass
from pathlib import Path

import cv2
import pytest

from cable_tracker.campaigns.crew import ClusterSettings, Crew, fingerprint_of, run_all
from cable_tracker.errors import ParameterError, ResourceError


@dataclass(frozen=True)
class Doubling:
    number: int

    def run(self, advance):
        advance()
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


@pytest.mark.parametrize("workers", [0, -1, 1000])
def test_the_number_of_workers_is_checked(workers):
    with pytest.raises(ParameterError, match=f"workers is {workers}"):
        run_all([Doubling(1)], workers=workers)


@dataclass(frozen=True)
class Counting:
    """Notes in a file that it was done."""

    number: int
    notes: Path

    def run(self, advance):
        with self.notes.open("a") as notes:
            notes.write(f"{self.number} ")
        advance()
        return self.number


def test_resuming_does_what_is_missing_or_has_changed(tmp_path):
    notes = tmp_path / "notes"
    crew = Crew(ClusterSettings(), tmp_path / "store", resume=True)
    for numbers in ((1, 2), (1, 2, 3)):
        assert run_all([Counting(n, notes) for n in numbers], workers=crew) == list(numbers)
    assert notes.read_text() == "1 2 3 "


def test_without_resuming_everything_is_done_again(tmp_path):
    notes = tmp_path / "notes"
    for _ in range(2):
        crew = Crew(ClusterSettings(), tmp_path / "store")
        run_all([Counting(1, notes)], workers=crew)
    assert notes.read_text() == "1 1 "


def test_a_kept_result_that_was_cut_off_is_done_again(tmp_path):
    notes, work = tmp_path / "notes", Counting(1, tmp_path / "notes")
    crew = Crew(ClusterSettings(), tmp_path / "store", resume=True)
    run_all([work], workers=crew)
    kept = tmp_path / "store" / fingerprint_of(work)
    kept.write_bytes(kept.read_bytes()[:-2])
    assert run_all([work], workers=crew) == [1]
    assert notes.read_text() == "1 1 "


def test_a_kept_result_runs_no_code(tmp_path):
    work, victim = Counting(1, tmp_path / "notes"), tmp_path / "victim"
    store = tmp_path / "store"
    store.mkdir()
    attack = pickle.dumps(Attack(victim))
    (store / fingerprint_of(work)).write_bytes(attack)
    assert run_all([work], workers=Crew(ClusterSettings(), store, resume=True)) == [1]
    assert not victim.exists()


def test_a_kept_result_reaches_nothing_that_a_module_imports(tmp_path):
    work, victim = Counting(1, tmp_path / "notes"), tmp_path / "victim"
    store = tmp_path / "store"
    store.mkdir()
    module = "cable_tracker.ros.process.child_process"
    attack = (
        b"\x80\x04" + pickle_text(module) + pickle_text("subprocess.Popen") + b"\x93"
        b"]" + b"(" + pickle_text("touch") + pickle_text(str(victim)) + b"e\x85R."
    )
    (store / fingerprint_of(work)).write_bytes(attack)
    assert run_all([work], workers=Crew(ClusterSettings(), store, resume=True)) == [1]
    assert not victim.exists()


def pickle_text(text):
    return pickle.BINUNICODE + len(text).to_bytes(4, "little") + text.encode()


def test_several_workers_without_dask_are_refused_with_what_to_do(monkeypatch):
    monkeypatch.delitem(sys.modules, "cable_tracker.campaigns.runner", raising=False)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ResourceError, match="pip install dask distributed"):
        run_all([Doubling(1), Doubling(2)], workers=2)


class Attack:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)
