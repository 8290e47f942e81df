"""Many runs of `cable-tracker loop`, each in processes and in a ROS domain of its own."""

from __future__ import annotations

import ctypes
import fcntl
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from cable_tracker.atomic_output import any_name, output_folder
from cable_tracker.campaigns.folder_tasks import (
    MARKER,
    Outcome,
    TaskState,
    fingerprint_of_files,
)
from cable_tracker.campaigns.result_store import stored_beside
from cable_tracker.campaigns.runner import run_folder_tasks
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.commands.console.terminal import (
    advance,
    console,
    print_files,
    print_table,
    progress_bar,
)
from cable_tracker.errors import RecordingError, RosError
from cable_tracker.evaluation.loop_table import (
    GOAL,
    METHODS_TABLE,
    RUNS,
    SUMMARY,
    LoopOutcome,
    LoopSummary,
    read_summary,
    totals_by_method,
    write_methods,
    write_runs,
)
from cable_tracker.evaluation.methods import METHODS
from cable_tracker.ros.process.child_process import GRACE, end_process, last_line_of
from cable_tracker.ros.process.environment import DOMAIN_VARIABLE

FIRST_DOMAIN, LAST_DOMAIN = 88, 101
"""Domains above the last collide with ephemeral ports."""

MOST_WORKERS = LAST_DOMAIN - FIRST_DOMAIN + 1

POLL = 0.2
"""Time between two looks at what has ended [s]."""

NODES_OF_RUN = 3
"""Number of nodes that a run starts: what tracks, controller and simulator."""

RUN_GRACE = (NODES_OF_RUN + 1) * GRACE
"""Time that a run gets to end after SIGTERM [s]. It stops its nodes one after the other, and each
of them gets its own time: a run that is killed before leaves nodes behind that nothing stops."""

RUN_HEADINGS = {
    "way": "way [m]",
    "rms": "RMS [m]",
    "most": "max [m]",
    "rms_offset": "y [m]",
    "wrong": "wrong",
    "losses": "losses",
    "longest_loss": "longest [s]",
    "lost_for_good": "lost for good",
}
"""Columns of the table of several runs on the terminal, with their headings."""

TOTAL_HEADINGS = {
    "method": "method",
    "runs": "runs",
    "failed": "failed",
    "kept": "kept",
    "within_goal": "in goal",
    "way": "way [m]",
    "rms": "RMS [m]",
    "worst_rms": "worst [m]",
    "most": "max [m]",
    "wrong": "wrong",
}


PR_SET_PDEATHSIG = 1
"""Number of the operation of prctl that sets the signal which a process gets when its parent
ends."""


@dataclass(frozen=True, slots=True)
class LoopTask:
    """One run.

    Attributes
    ----------
    method, seed
        Name of the method that tracks, and seed of the world.
    arguments : tuple of str
        Arguments of `cable-tracker loop`.
    files : tuple of Path
        Files that they name.
    """

    method: str
    seed: int
    arguments: tuple[str, ...]
    files: tuple[Path, ...] = ()

    is_own_name = staticmethod(any_name)

    @property
    def name(self) -> str:
        """Name of its folder."""
        return f"{self.method}_{self.seed}"

    def fingerprint(self) -> str:
        """Return a text that changes with what is run, and with the files."""
        return f"{self!r} {fingerprint_of_files(*self.files)}"

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        """Run it in processes of its own.

        Raises
        ------
        RosError
            It has not come to its end; the message is its last line.
        """
        result = folder / "run"
        own = ["--method", self.method, "--seed", str(self.seed), "--output", str(result)]
        # A file, not a pipe: it is not read while the run lasts.
        with tempfile.TemporaryFile() as said, free_domain() as domain:
            process = subprocess.Popen(
                [sys.executable, "-m", "cable_tracker.cli", "loop", *own, *self.arguments],
                env={**os.environ, DOMAIN_VARIABLE: str(domain)},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=said,
                # A Ctrl-C reaches it through us alone, once; and it does not outlive us.
                start_new_session=True,
                preexec_fn=_end_with_parent,  # noqa: PLW1509  It only calls the kernel.
            )
            try:
                # Sleeping instead of waiting for threads: a signal may come any time.
                while process.poll() is None:
                    time.sleep(POLL)
            finally:
                end_process(process, RUN_GRACE)
            said.seek(0)
            lines = said.read().decode(errors="replace").splitlines()
        advance(1)
        if process.returncode:
            reason = last_line_of(lines) or f"it ended with code {process.returncode}"
            raise RosError(reason.removeprefix("error: "))
        for file in result.iterdir():
            shutil.move(file, folder / file.name)
        result.rmdir()


def _end_with_parent() -> None:
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


@contextmanager
def free_domain() -> Iterator[int]:
    """Give a ROS domain that no other run on this machine uses; wait while there is none."""
    folder = Path(tempfile.gettempdir())
    while True:
        for domain in range(FIRST_DOMAIN, LAST_DOMAIN + 1):
            with (folder / f"cable_tracker_domain_{domain}_{os.getuid()}.lock").open("w") as lock:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except OSError:
                    continue
                yield domain
                return
        time.sleep(POLL)


def run_loops(
    tasks: Sequence[LoopTask],
    folder: Path,
    cluster: ClusterSettings,
    *,
    resume: bool,
    advance: Callable[[], None],
) -> list[LoopOutcome]:
    """Run everything; a run that fails is an outcome like any other.

    Parameters
    ----------
    tasks : sequence of LoopTask
        The runs.
    folder : Path
        Gets a folder METHOD_SEED for each run that comes to its end.
    cluster : ClusterSettings
        Machines that run them.
    resume : bool
        Keep the runs that are there already.
    advance : callable
        Called after each run.

    Returns
    -------
    list of LoopOutcome
        One for each run, in their order.
    """
    outcomes = run_folder_tasks(
        tasks, folder, cluster, resume=resume, finished=lambda outcome: advance()
    )
    return [_outcome(task, each, folder) for task, each in zip(tasks, outcomes, strict=True)]


def _outcome(task: LoopTask, outcome: Outcome, folder: Path) -> LoopOutcome:
    if outcome.state is TaskState.FAILED:
        return LoopOutcome(task.method, task.seed, None, outcome.reason)
    try:
        return LoopOutcome(task.method, task.seed, read_summary(folder / task.name / SUMMARY))
    except RecordingError as error:
        return LoopOutcome(task.method, task.seed, None, str(error))


def follow_several(
    tasks: Sequence[LoopTask],
    path: Path,
    cluster: ClusterSettings,
    *,
    force: bool,
    resume: bool,
) -> None:
    """Follow the cable in several runs, write their tables beside their folders, and print them.

    Raises
    ------
    typer.Exit
        A run has failed.
    """
    with (
        output_folder(
            path, RUNS, overwrite=force or resume, is_own_name=_is_of_several_runs
        ) as folder,
        stored_beside(path, cluster, resume=resume) as settings,
    ):
        assert settings.store is not None
        if resume and path.is_dir():
            _copy_runs(path, settings.store)
        with progress_bar("runs", len(tasks)) as progress:
            outcomes = run_loops(
                tasks, settings.store, cluster, resume=resume, advance=lambda: advance(progress)
            )
        totals = totals_by_method(outcomes)
        write_runs(folder / RUNS, outcomes)
        write_methods(folder / METHODS_TABLE, totals)
        # The folders of the runs stand beside the tables. They come last: what stops the writing of
        # the tables must not take the runs with it.
        for run in settings.store.iterdir():
            shutil.move(run, folder / run.name)
        settings.store.rmdir()
    _print_runs(outcomes)
    _print_totals(totals)
    print_files(path, (RUNS, METHODS_TABLE))
    if any(each["failed"] for each in totals):
        raise typer.Exit(1)


def _copy_runs(path: Path, store: Path) -> None:
    """Copy the folders of earlier runs into a store that holds no newer ones of these names."""
    for run in (marker.parent for marker in path.glob(f"*/{MARKER}")):
        if not (store / run.name).exists():
            shutil.copytree(run, store / run.name)


def _is_of_several_runs(name: str) -> bool:
    """Tell by its name whether several runs write a file or a folder beside each other."""
    method, _, seed = name.rpartition("_")
    is_of_run = method in METHODS and seed.isdecimal()
    return is_of_run or name in {RUNS, METHODS_TABLE}


def _print_runs(outcomes: Sequence[LoopOutcome]) -> None:
    rows = ((each.method, str(each.seed), *_cells_of(each.summary)) for each in outcomes)
    headings = ("method", "seed", *RUN_HEADINGS.values())
    print_table("closed loops", headings, rows, left=(0,), narrow=True)
    for outcome in outcomes:
        if outcome.failure:
            console.print(f"{outcome.method}, seed {outcome.seed}: {outcome.failure}")


def _cells_of(summary: LoopSummary | None) -> list[str]:
    if summary is None:
        return ["failed"]
    return [format_measure(name, getattr(summary, name)) for name in RUN_HEADINGS]


def _print_totals(totals: Sequence[dict[str, Any]]) -> None:
    title = f"by method; kept: not lost for good; goal: RMS of {GOAL:g} m; way, RMS: medians"
    rows = ([format_measure(name, each[name]) for name in TOTAL_HEADINGS] for each in totals)
    print_table(title, TOTAL_HEADINGS.values(), rows, left=(0,), narrow=True)


def format_measure(name: str, value: object) -> str:
    """Write a field of a run's summary, or of a method's totals, for people."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "-"
    return f"{value:.1%}" if name in {"answered", "measured", "wrong"} else f"{value:.3g}"
