"""A cluster of Dask: one of this machine's own, or one that is running elsewhere."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import dask
from dask.utils import parse_bytes
from distributed import Client, LocalCluster

from cable_tracker import __version__
from cable_tracker.campaigns.settings import DASHBOARD, ClusterSettings
from cable_tracker.errors import ParameterError, one_line

CONNECT_TIMEOUT = 60.0
"""Longest wait for a scheduler [s]."""

LEAST_MEMORY = 256 * 2**20
"""Smallest memory of a worker [bytes]: the libraries alone take it. One that has less is ended
while it begins, and begun again, for ever."""

FREE_PORT = "127.0.0.1:0"

KEPT_MEMORY = {"MALLOC_TRIM_THRESHOLD_": 64 * 2**20, "MALLOC_MMAP_THRESHOLD_": 32 * 2**20}
"""Freed memory that a worker keeps, and the largest block that it takes from there [bytes]. By
Dask's own setting a worker returns all beyond 64 KiB: each frame would ask the system for its
arrays anew, which took a fifth of the processor."""


@contextmanager
def connected(settings: ClusterSettings) -> Iterator[Client]:
    """Connect to the cluster, which is started and stopped if it is this machine's own.

    Raises
    ------
    ParameterError
        There is no scheduler at the address, it has no workers, one of them has another version of
        this package, or the memory of workers is no size, or too small.
    """
    quiet = {
        "distributed.scheduler.allowed-failures": 3,
        "distributed.comm.timeouts.connect": f"{CONNECT_TIMEOUT}s",
        # Python's own start method "fork" may hang with the threads of OpenCV and Numba.
        "distributed.worker.multiprocessing-method": "spawn",
        "distributed.nanny.pre-spawn-environ": worker_environment(),
    }
    with dask.config.set(quiet):
        if settings.scheduler is None:
            with _local(settings) as cluster, Client(cluster) as client:
                if settings.dashboard:
                    settings.on_dashboard(cluster.dashboard_link)
                check_versions(client)
                yield client
            return
        try:
            client = Client(settings.scheduler, timeout=CONNECT_TIMEOUT)
        except (OSError, ValueError, TimeoutError) as error:
            raise ParameterError(
                f"scheduler: none answers at {settings.scheduler} ({one_line(error)}); start one"
                " with `dask scheduler`"
            ) from error
        with client:
            check_versions(client)
            yield client


def worker_environment() -> dict[str, Any]:
    """Return the environment variables of workers that are started here."""
    return {**dask.config.get("distributed.nanny.pre-spawn-environ", {}), **KEPT_MEMORY}


def _check_memory(text: str) -> None:
    """Check that a size of memory in bytes suffices for a worker.

    Up to 1 Dask takes it for a share of the machine's memory, and 0 for all of it.

    Raises
    ------
    ValueError
        The text is no size.
    ParameterError
        The size is too small.
    """
    size = 0 if text == "auto" else parse_bytes(text)
    if not (0 <= size <= 1 or size >= LEAST_MEMORY):
        raise ParameterError(
            f"memory: {text} is too little, a worker takes {LEAST_MEMORY // 2**20} MiB before it"
            " has begun; give a size such as 2GiB"
        )


def _local(settings: ClusterSettings) -> LocalCluster:
    memory = settings.memory.replace(" ", "")
    try:
        _check_memory(memory)
        return LocalCluster(
            n_workers=settings.workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            silence_logs=logging.CRITICAL,
            memory_limit=memory,
            dashboard_address=DASHBOARD if settings.dashboard else None,
            # Its server is started even without pages: at a port that is free.
            scheduler_kwargs={} if settings.dashboard else {"dashboard_address": FREE_PORT},
        )
    except ValueError as error:
        raise ParameterError(f"memory: {one_line(error)}; give a size such as 2GiB") from error


def version_here() -> str:
    """Return the version of this package in this process."""
    return __version__


class OtherVersions:
    """Workers of another version that come while a campaign runs.

    Parameters
    ----------
    client : Client
        The campaign's.
    version : str
        Version of the campaign.
    notify : callable
        Called with a sentence about each worker that is retired.

    Attributes
    ----------
    has_retired : bool
        Whether a worker was retired.
    """

    def __init__(self, client: Client, version: str, notify: Callable[[str], None]) -> None:
        self._client, self._version, self._notify = client, version, notify
        self.has_retired = False

    def retire(self) -> bool:
        """Retire such workers; tell whether one of the right version is left, else retire none.

        A worker that refuses a task is free for the next one at once: left alone it would take
        whatever the others have not begun.
        """
        found = self._client.run(version_here, on_error="return")
        if self._version not in found.values():
            return False
        # What cannot be reached now is no worker of another version.
        others = {
            address: f"has cable_tracker {version}"
            if isinstance(version, str)
            else "cannot load it"
            for address, version in found.items()
            if version != self._version and isinstance(version, str | ImportError | AttributeError)
        }
        if others:
            self._client.retire_workers(list(others))
            self.has_retired = True
        for address, what in others.items():
            self._notify(
                f"the worker at {address} {what}, the campaign {self._version}; it is retired, and"
                " the others do its tasks; install one version on all workers"
            )
        return True


def check_versions(client: Client) -> None:
    """Check that all workers have this version of the package.

    Raises
    ------
    ParameterError
        One has not, or there are none.
    """
    try:
        found: dict[str, Any] = client.run(version_here)
    # What a worker without this package raises comes from its unpickling, in many types.
    except Exception as error:
        raise ParameterError(
            f"scheduler: a worker cannot load cable_tracker {__version__}"
            f" ({one_line(error)}); install this version on all workers"
        ) from error
    if not found:
        raise ParameterError("scheduler: it has no workers; start some with `dask worker ADDRESS`")
    others = {address: version for address, version in found.items() if version != __version__}
    if others:
        listed = ", ".join(f"{address} has {version}" for address, version in others.items())
        raise ParameterError(
            f"scheduler: this is cable_tracker {__version__}, but {listed}; install one version on"
            " all workers"
        )
