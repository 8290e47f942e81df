"""Many runs of `cable-tracker loop`, each in processes and in a ROS domain of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue

from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.closed_loop import SUMMARY, read_summary
from cable_tracker.evaluation.closed_loop_campaign import LoopOutcome

DOMAIN_VARIABLE = "ROS_DOMAIN_ID"
FIRST_DOMAIN, LAST_DOMAIN = 88, 101
"""Domains above the last collide with ephemeral ports."""

MOST_WORKERS = LAST_DOMAIN - FIRST_DOMAIN + 1

GRACE = 30.0
"""Time that a run gets to stop its nodes [s]."""


@dataclass(frozen=True, slots=True)
class LoopCampaign:
    """What to run.

    Attributes
    ----------
    methods : sequence of str
        Of `evaluation.methods.METHODS`.
    seeds : sequence of int
        Each method runs with each of them.
    arguments : sequence of str
        Of `cable-tracker loop`, which all runs share.
    workers : int
        How many runs at once, 1 to `MOST_WORKERS`.
    """

    methods: Sequence[str]
    seeds: Sequence[int]
    arguments: Sequence[str] = ()
    workers: int = 1

    def cases(self) -> list[tuple[str, int]]:
        """Return method and seed of all runs."""
        return [(method, seed) for method in self.methods for seed in self.seeds]


def run_campaign(
    campaign: LoopCampaign, folder: Path, advance: Callable[[], None] = lambda: None
) -> list[LoopOutcome]:
    """Run everything; a run that fails is an outcome like any other.

    Parameters
    ----------
    campaign : LoopCampaign
        What to run.
    folder : Path
        Gets a folder METHOD_SEED for each run that comes to its end.
    advance : callable
        Called after each run.

    Returns
    -------
    list of LoopOutcome
        By method, then seed, in the campaign's order.
    """
    runner = _Runner(campaign.arguments, folder, campaign.workers)
    with ThreadPoolExecutor(campaign.workers) as pool:
        futures = [pool.submit(runner.run, *case) for case in campaign.cases()]
        try:
            for _ in as_completed(futures):
                advance()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            runner.stop()
            raise
    return [future.result() for future in futures]


@dataclass(slots=True)
class _Runner:
    arguments: Sequence[str]
    folder: Path
    workers: int
    domains: SimpleQueue[int] = field(default_factory=SimpleQueue)
    processes: dict[int, subprocess.Popen[str]] = field(default_factory=dict)
    stopped: bool = False

    def __post_init__(self) -> None:
        for number in range(self.workers):
            self.domains.put(FIRST_DOMAIN + number)

    def run(self, method: str, seed: int) -> LoopOutcome:
        """Run one case, and wait for its end."""
        domain = self.domains.get()
        try:
            return self._run(method, seed, domain)
        finally:
            self.domains.put(domain)

    def _run(self, method: str, seed: int, domain: int) -> LoopOutcome:
        path = self.folder / f"{method}_{seed}"
        own = ["--method", method, "--seed", str(seed), "--output", str(path)]
        process = subprocess.Popen(
            [sys.executable, "-m", "cable_tracker.cli", "loop", *own, *self.arguments],
            env={**os.environ, DOMAIN_VARIABLE: str(domain)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            # A Ctrl-C reaches it through us alone, once.
            start_new_session=True,
        )
        self.processes[domain] = process
        if self.stopped:
            process.terminate()
        _, said = process.communicate()
        if process.returncode:
            return LoopOutcome(method, seed, None, _last_line(said, process.returncode))
        try:
            return LoopOutcome(method, seed, read_summary(path / SUMMARY))
        except RecordingError as error:
            return LoopOutcome(method, seed, None, str(error))

    def stop(self) -> None:
        """End all runs; each of them stops its nodes."""
        self.stopped = True
        for process in list(self.processes.values()):
            process.terminate()
        for process in list(self.processes.values()):
            try:
                process.wait(GRACE)
            except subprocess.TimeoutExpired:
                process.kill()


def _last_line(said: str, code: int) -> str:
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return lines[-1].removeprefix("error: ") if lines else f"it ended with code {code}"
