"""Options of the commands that do many runs, and what is made of them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.campaigns.settings import DASHBOARD, LARGEST_WORKER_COUNT, ClusterSettings
from cable_tracker.commands.console.terminal import messages, print_note
from cable_tracker.errors import ParameterError

MEMORY = "4 GiB"
"""Memory of each worker, unless the user names another."""

LARGEST_FIRST_SEED = 1_000_000_000
"""Far enough below the largest seed of a tracker for all that is added to it."""

FirstSeedOption = Annotated[
    int, typer.Option(help="Seed of the first run; keep seeds for tuning and for reports apart.")
]
SeedsOption = Annotated[
    int, typer.Option(help="Number of runs, with the first seed and those that follow it.")
]
WorkersOption = Annotated[
    int | None, typer.Option(help="Number of processes.  [default: one for each processor]")
]
SchedulerOption = Annotated[
    str | None, typer.Option(help="Address of a running Dask scheduler: tcp://host:8786.")
]
MemoryOption = Annotated[str, typer.Option(help="Largest memory of each worker.")]
DashboardOption = Annotated[
    bool, typer.Option("--dashboard", help=f"Serve Dask's pages at {DASHBOARD} while workers run.")
]
ResumeOption = Annotated[
    bool, typer.Option("--resume", help="Do only what is missing or has changed.")
]


def chosen_cluster(
    workers: int | None, scheduler: str | None, memory: str, dashboard: bool
) -> ClusterSettings:
    """Return where tasks run; where Dask's pages are is said when they are served.

    Raises
    ------
    ParameterError
        The number of workers is out of range, or pages are asked for that would not be served.
    """
    if workers is None:
        workers = min(os.cpu_count() or 1, LARGEST_WORKER_COUNT)
    if dashboard and scheduler is not None:
        raise ParameterError(
            "dashboard: a scheduler that is running serves its own pages; leave out --dashboard"
        )
    if dashboard and workers == 1:
        raise ParameterError(
            "dashboard: Dask serves it, and a single worker runs without Dask; give --workers 2"
            " or more, or leave out --dashboard"
        )
    return ClusterSettings(workers, scheduler, memory, dashboard, _print_address, print_note)


def _print_address(dashboard: str) -> None:
    messages.print(f"Dask's pages: {dashboard}", soft_wrap=True)


def with_whole_paths(parameters: TrackerParameters) -> TrackerParameters:
    """Return parameters that name their files as workers in other folders find them too.

    Links stay links: their names are those that the user knows.
    """
    if not parameters.response_table:
        return parameters
    table = Path(parameters.response_table).absolute()
    return parameters.replaced({"response_table": str(table)})


def seeds_from(count: int, first: int) -> tuple[int, ...]:
    """Return a count of seeds from a first one upwards.

    Raises
    ------
    ParameterError
        The count is not positive, or the first seed out of range.
    """
    if count < 1:
        raise ParameterError(f"seeds is {count}: give at least 1")
    if not 0 <= first <= LARGEST_FIRST_SEED:
        raise ParameterError(f"first-seed is {first}: give 0 to {LARGEST_FIRST_SEED}")
    return tuple(range(first, first + count))
