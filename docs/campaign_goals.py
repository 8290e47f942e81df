"""Measure what a campaign costs beside its tasks: many short recordings, and two workers.

    python docs/campaign_goals.py FOLDER [--recordings 1000] [--alone 40] [--length 2] [--workers 2]

One dive is simulated and copied. Some copies are surveyed one after the other in this process, all
of them by the workers of a cluster on this machine, as `cable-tracker survey` does; routes are not
merged. Two processes at once slow each other down, through memory, caches and what else the machine
does. That is no cost of the campaign, so it is told apart: each task notes when it began and ended.
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from cable_tracker import __version__
from cable_tracker.campaigns.crew import ClusterSettings
from cable_tracker.campaigns.runner import run_campaign
from cable_tracker.campaigns.task import TaskState, do
from cable_tracker.simulation.survey_bag import write_survey_bag
from cable_tracker.simulation.survey_dive import SurveySettings as Simulated
from cable_tracker.survey.campaign import SurveyTask
from cable_tracker.survey.forwards import ForwardSettings
from cable_tracker.survey.recording import SurveySettings

RATE = 25.0
"""Pictures per second; all of them are tracked."""

TIMES = "times.txt"


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--recordings", type=int, default=1000)
    parser.add_argument("--alone", type=int, default=40)
    parser.add_argument("--length", type=float, default=2.0)
    parser.add_argument("--workers", type=int, default=2)
    chosen = parser.parse_args()
    tasks = _tasks(chosen.folder / "dives", chosen.recordings, chosen.length)
    root = chosen.folder / "surveyed"
    shutil.rmtree(root, ignore_errors=True)
    each = _seconds_alone(tasks[: chosen.alone], root / "alone")
    begin, begun = time.perf_counter(), time.time()
    settings = ClusterSettings(workers=chosen.workers)
    (root / "all").mkdir(parents=True)
    outcomes = run_campaign(tasks, root / "all", settings)
    seconds = time.perf_counter() - begin
    failed = sum(outcome.state is TaskState.FAILED for outcome in outcomes)
    share = each * len(tasks) / chosen.workers
    print(f"{each:.3f} s for a recording of {chosen.length:g} m, alone ({chosen.alone} of them)")
    print(f"{len(tasks)} recordings, {chosen.workers} workers: {seconds:.1f} s, {failed} failed")
    spans = [_span(root / "all" / task.name) for task in tasks if not _failed(root, task)]
    first = min(begin for begin, _ in spans) - begun
    last = begun + seconds - max(end for _, end in spans)
    own = sum(end - begin for begin, end in spans) / chosen.workers
    print(f"{seconds / own:.3f} times the sum of their own times over the workers")
    print(f"{first:.1f} s until the first begins, {last:.1f} s after the last")
    print(f"{seconds / share:.3f} times their sum over the workers, each as long as alone")
    print(f"{each * len(tasks) / seconds:.2f} times as fast as one process")


@dataclass(frozen=True, slots=True)
class TimedTask:
    """A survey of a recording that notes when it was done."""

    task: SurveyTask

    @property
    def name(self) -> str:
        """Of the folder that its results go to."""
        return self.task.name

    def fingerprint(self) -> str:
        """Return that of the survey."""
        return self.task.fingerprint()

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        """Survey, and note the times [s]."""
        begin = time.time()
        self.task.run(folder, advance)
        (folder / TIMES).write_text(f"{begin} {time.time()}", encoding="utf-8")


def _failed(root: Path, task: TimedTask) -> bool:
    return not (root / "all" / task.name / TIMES).exists()


def _span(folder: Path) -> tuple[float, float]:
    begin, end = (folder / TIMES).read_text(encoding="utf-8").split()
    return float(begin), float(end)


def _tasks(folder: Path, count: int, length: float) -> list[TimedTask]:
    first = folder / "dive_0"
    if not first.exists():
        write_survey_bag(first, Simulated(length=length, rate=RATE))
    settings = SurveySettings(ForwardSettings(most_rate=0.0), pictures=False)
    names = [f"dive_{number}" for number in range(count)]
    for name in names[1:]:
        if not (folder / name).exists():
            shutil.copytree(first, folder / name)
    return [TimedTask(SurveyTask(folder / name, settings, name)) for name in names]


def _seconds_alone(tasks: Sequence[TimedTask], root: Path) -> float:
    """Return how long a task takes in this process [s], once machine code is loaded."""
    root.mkdir(parents=True)
    do(tasks[0], root, __version__, lambda count: None)
    begin = time.perf_counter()
    for task in tasks:
        do(task, root, __version__, lambda count: None)
    return (time.perf_counter() - begin) / len(tasks)


if __name__ == "__main__":
    main()
