"""Settings of a campaign: the machines that run its tasks, and the folder of results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from cable_tracker.errors import ParameterError

LARGEST_WORKER_COUNT = 256

DASHBOARD = "127.0.0.1:8787"
"""Address at which Dask serves its pages, if it is asked to."""


def _ignore(_text: str) -> None:
    pass


@dataclass(frozen=True, slots=True)
class ClusterSettings:
    """Machines that run tasks.

    Attributes
    ----------
    workers : int
        Processes of a cluster on this machine.
    scheduler : str or None
        Address of a running scheduler, as tcp://host:8786; None: a cluster of this machine's own.
    memory : str
        Most memory of each worker, as "2 GiB"; it is restarted when it takes more.
    dashboard : bool
        Serve Dask's pages at `DASHBOARD`.
    on_dashboard : callable
        Called with the address of Dask's pages once they are served.
    on_notice : callable
        Called with what the user should know of the workers, in words.

    Raises
    ------
    ParameterError
        The number of workers is out of range.
    """

    workers: int = 1
    scheduler: str | None = None
    memory: str = "4 GiB"
    dashboard: bool = False
    on_dashboard: Callable[[str], None] = field(default=_ignore, repr=False, compare=False)
    on_notice: Callable[[str], None] = field(default=_ignore, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not 1 <= self.workers <= LARGEST_WORKER_COUNT:
            raise ParameterError(f"workers is {self.workers}: give 1 to {LARGEST_WORKER_COUNT}")

    def is_here(self, count: int) -> bool:
        """Tell whether tasks are done in this process."""
        return self.scheduler is None and (self.workers == 1 or count <= 1)


@dataclass(frozen=True, slots=True)
class CampaignSettings:
    """Machines that run tasks with results, and the folder that keeps these.

    Attributes
    ----------
    cluster : ClusterSettings
        Machines that run the tasks.
    store : Path or None
        Folder for the result of each task; None: they are not kept.
    resume : bool
        Take from the store what is there of the same task and version.
    """

    cluster: ClusterSettings = field(default_factory=ClusterSettings)
    store: Path | None = None
    resume: bool = False


HERE = CampaignSettings()
"""One worker, which is this process; no result is kept."""
