"""Many runs of `cable-tracker loop`, each in processes and in a ROS domain of its own."""

from __future__ import annotations

import ctypes
import fcntl
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

from cable_tracker.atomic_output import any_name
from cable_tracker.campaigns.folder_tasks import Outcome, TaskState, fingerprint_of_files
from cable_tracker.campaigns.runner import run_folder_tasks
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.errors import RecordingError, RosError
from cable_tracker.evaluation.closed_loop.loop_campaign import LoopOutcome
from cable_tracker.evaluation.closed_loop.loop_table import SUMMARY, read_summary
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


def is_folder_of_run(name: str) -> bool:
    """Tell by its name whether a run of several has its results in a folder."""
    method, _, seed = name.rpartition("_")
    return method in METHODS and seed.isdecimal()


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
        Where they run.
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
