"""Measure what a campaign costs beside its tasks: many short recordings, and two workers.

    python docs/campaign_goals.py FOLDER [--recordings 1000] [--alone 40] [--length 2] [--workers 2]

One dive is simulated and copied. Some copies are surveyed one after the other in this process, all
of them by the workers of a cluster on this machine, as `cable-tracker survey` does; routes are not
merged. Two processes at once slow each other down, through memory, caches and what else the machine
does. That is no cost of the campaign, so it is separated: each task notes when it began and ended,
and how much of the processor it took.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from cable_tracker import __version__
from cable_tracker.campaigns.folder_tasks import TaskState, run_in_folder
from cable_tracker.campaigns.runner import run_folder_tasks
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings as Simulated
from cable_tracker.simulation.instruments.survey_dive import write_survey_bag
from cable_tracker.survey.campaign import SurveyTask
from cable_tracker.survey.forward_pass import ForwardSettings
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
    each, processor_each = _seconds_alone(tasks[: chosen.alone], root / "alone")
    begin, begun, processor = time.perf_counter(), time.time(), _processor_time()
    settings = ClusterSettings(workers=chosen.workers)
    (root / "all").mkdir(parents=True)
    outcomes = run_folder_tasks(tasks, root / "all", settings)
    seconds, processor = time.perf_counter() - begin, _processor_time() - processor
    failed = sum(outcome.state is TaskState.FAILED for outcome in outcomes)
    share = each * len(tasks) / chosen.workers
    print(f"{each:.3f} s for a recording of {chosen.length:g} m, alone ({chosen.alone} of them)")
    print(f"{len(tasks)} recordings, {chosen.workers} workers: {seconds:.1f} s, {failed} failed")
    spans = [_span(root / "all" / task.name) for task in tasks if not _failed(root, task)]
    first = min(span.begin for span in spans) - begun
    last = begun + seconds - max(span.end for span in spans)
    own = sum(span.end - span.begin for span in spans) / chosen.workers
    processor_own = sum(span.processor for span in spans)
    print(f"{seconds / own:.3f} times the sum of their own times over the workers")
    print(f"{first:.1f} s until the first begins, {last:.1f} s after the last")
    print(f"{seconds / share:.3f} times their sum over the workers, each as long as alone")
    print(f"{each * len(tasks) / seconds:.2f} times as fast as one process")
    print(f"{processor:.1f} s of processor time, {processor / processor_own:.3f} times the tasks'")
    print(f"a task takes {processor_own / len(spans) / processor_each:.3f} times that of one alone")


@dataclass(frozen=True, slots=True)
class TimedTask:
    """A survey of a recording that notes when it was done."""

    task: SurveyTask

    @property
    def name(self) -> str:
        """Name of the folder that its results go to."""
        return self.task.name

    def fingerprint(self) -> str:
        """Return that of the survey."""
        return self.task.fingerprint()

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        """Survey, and note the times [s]."""
        begin, processor = time.time(), time.process_time()
        self.task.run(folder, advance)
        times = f"{begin} {time.time()} {time.process_time() - processor}"
        (folder / TIMES).write_text(times, encoding="utf-8")

    def is_own_name(self, name: str) -> bool:
        """Tell whether the survey writes a file of this name, or it is that of the times."""
        return name == TIMES or self.task.is_own_name(name)


class Span(NamedTuple):
    """When a task began and ended, and the processor time of its process between [s]."""

    begin: float
    end: float
    processor: float


def _failed(root: Path, task: TimedTask) -> bool:
    return not (root / "all" / task.name / TIMES).exists()


def _span(folder: Path) -> Span:
    return Span(*map(float, (folder / TIMES).read_text(encoding="utf-8").split()))


def _processor_time() -> float:
    """Return the processor time of this process and of its children that have ended [s]."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    used = [resource.getrusage(kind) for kind in kinds]
    return sum(each.ru_utime + each.ru_stime for each in used)


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


def _seconds_alone(tasks: Sequence[TimedTask], root: Path) -> tuple[float, float]:
    """Return time and processor time of a task in this process [s], once machine code is loaded."""
    root.mkdir(parents=True)
    run_in_folder(tasks[0], root, __version__, lambda count: None)
    begin, processor = time.perf_counter(), time.process_time()
    for task in tasks:
        run_in_folder(task, root, __version__, lambda count: None)
    seconds, processor = time.perf_counter() - begin, time.process_time() - processor
    return seconds / len(tasks), processor / len(tasks)


if __name__ == "__main__":
    main()
