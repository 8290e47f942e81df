"""Many runs of `cable-tracker loop`, each in processes and in a ROS domain of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.closed_loop.loop_campaign import LoopOutcome
from cable_tracker.evaluation.closed_loop.loop_table import SUMMARY, read_summary

DOMAIN_VARIABLE = "ROS_DOMAIN_ID"
FIRST_DOMAIN, LAST_DOMAIN = 88, 101
"""Domains above the last collide with ephemeral ports."""

MOST_WORKERS = LAST_DOMAIN - FIRST_DOMAIN + 1

POLL = 0.2
"""Time between two looks at what has ended [s]."""

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
    cases = campaign.cases()
    waiting = deque(cases)
    free = [FIRST_DOMAIN + number for number in range(campaign.workers)]
    running: list[_Run] = []
    outcomes: dict[tuple[str, int], LoopOutcome] = {}
    try:
        # Sleeping instead of waiting for threads: a signal may come any time.
        while waiting or running:
            while waiting and free:
                running.append(_Run.start(waiting.popleft(), free.pop(), campaign, folder))
            time.sleep(POLL)
            for run in [run for run in running if run.process.poll() is not None]:
                running.remove(run)
                free.append(run.domain)
                outcomes[run.case] = run.outcome()
                advance()
    finally:
        _stop(running)
    return [outcomes[case] for case in cases]


@dataclass(frozen=True, slots=True, eq=False)
class _Run:
    case: tuple[str, int]
    domain: int
    path: Path
    process: subprocess.Popen[bytes]
    said: IO[bytes]

    @classmethod
    def start(
        cls, case: tuple[str, int], domain: int, campaign: LoopCampaign, folder: Path
    ) -> _Run:
        method, seed = case
        path = folder / f"{method}_{seed}"
        own = ["--method", method, "--seed", str(seed), "--output", str(path)]
        # A file, not a pipe: nobody reads while it runs.
        said = tempfile.TemporaryFile()  # noqa: SIM115  It lives as long as the run.
        process = subprocess.Popen(
            [sys.executable, "-m", "cable_tracker.cli", "loop", *own, *campaign.arguments],
            env={**os.environ, DOMAIN_VARIABLE: str(domain)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=said,
            # A Ctrl-C reaches it through us alone, once.
            start_new_session=True,
        )
        return cls(case, domain, path, process, said)

    def outcome(self) -> LoopOutcome:
        """Return what came of it, once it has ended."""
        method, seed = self.case
        with self.said as said:
            said.seek(0)
            lines = said.read().decode(errors="replace").splitlines()
        if self.process.returncode:
            reason = next((line.strip() for line in reversed(lines) if line.strip()), "")
            reason = reason or f"it ended with code {self.process.returncode}"
            return LoopOutcome(method, seed, None, reason.removeprefix("error: "))
        try:
            return LoopOutcome(method, seed, read_summary(self.path / SUMMARY))
        except RecordingError as error:
            return LoopOutcome(method, seed, None, str(error))


def _stop(running: Sequence[_Run]) -> None:
    """End runs that are on their way; each of them stops its nodes."""
    for run in running:
        run.process.terminate()
    for run in running:
        try:
            run.process.wait(GRACE)
        except subprocess.TimeoutExpired:
            run.process.kill()
            run.process.wait()
        run.said.close()
