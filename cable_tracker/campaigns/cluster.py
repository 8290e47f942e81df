"""A cluster of Dask, this machine's own or one that runs elsewhere, and what its workers do."""

from __future__ import annotations

import logging
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import dask
from dask.utils import parse_bytes
from distributed import Client, Future, LocalCluster, as_completed, get_worker
from distributed.scheduler import KilledWorker

from cable_tracker import __version__
from cable_tracker.campaigns.runner import Advance, Ended
from cable_tracker.campaigns.settings import DASHBOARD, ClusterSettings
from cable_tracker.errors import CableTrackerError, ParameterError, one_line
from cable_tracker.libraries import one_thread

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

PROGRESS = "cable_tracker progress"
"""Topic on which workers report their progress."""

REPORT_EVERY = 0.5
"""Least time between two reports of a worker [s]."""

MOST_REFUSALS = 3
"""Number of times that a task is given to the workers anew; each time others have come between."""

Result = TypeVar("Result")


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


class _ProgressReporter:
    """Reports a task's progress to the client, at most every `REPORT_EVERY`."""

    def __init__(self, number: int) -> None:
        self._number = number
        self.total = 0
        self._count = 0
        self._last = time.monotonic()

    def __call__(self, count: int) -> None:
        self.total += count
        self._count += count
        if time.monotonic() - self._last >= REPORT_EVERY:
            self.report()

    def report(self) -> None:
        if self._count:
            get_worker().log_event(PROGRESS, (self._number, self._count))
        self._count, self._last = 0, time.monotonic()


REFUSAL = "the worker has cable_tracker "
"""Beginning of what a worker of another version says of each task. All versions say it so."""


def _in_worker(
    work: Callable[[_ProgressReporter], Result], number: int, version: str
) -> tuple[Result, int]:
    """Do a task in a worker; return its result, and how many frames it had."""
    if version != __version__:
        raise ParameterError(
            f"{REFUSAL}{__version__}, the campaign {version}; install one version on all workers"
        )
    reporter = _ProgressReporter(number)
    with one_thread():
        return work(reporter), reporter.total


def run_on_cluster(
    settings: ClusterSettings,
    calls: Sequence[Callable[[Advance], object]],
    advance: Advance,
) -> Generator[Ended]:
    """Let workers run `calls`, each given a function to report progress; yield the ended tasks.

    A task that a worker of another version has refused is given to others, as long as there are
    any. When the generator is closed, tasks that have not ended are given up.
    """
    progress = _Progress(advance)
    refusals = Counter[int]()
    with connected(settings) as client:
        client.subscribe_topic(PROGRESS, lambda event: progress.report(*event[1]))
        others = OtherVersions(client, __version__, settings.on_notice)

        def submit(number: int) -> Future:
            return client.submit(_in_worker, calls[number], number, __version__, pure=False)

        futures = {submit(number): number for number in range(len(calls))}
        ended = as_completed(futures)
        try:
            for future in ended:
                number, error = futures[future], future.exception()
                if error is None:
                    result, total = future.result()
                    progress.end(number, total)
                    yield Ended(number, result)
                elif refusals[number] < MOST_REFUSALS and _is_for_others(error, others):
                    refusals[number] += 1
                    again = submit(number)
                    futures[again] = number
                    ended.add(again)
                else:
                    yield Ended(number, error=_readable_error(error))
        finally:
            client.cancel(list(futures))
            client.unsubscribe_topic(PROGRESS)


def _is_for_others(error: BaseException, others: OtherVersions) -> bool:
    """Tell whether a task has failed for its worker's version, and another worker may do it."""
    if str(error).startswith(REFUSAL):
        return others.retire()
    # A version that is far away may not even be able to read the task.
    if isinstance(error, KilledWorker | CableTrackerError):
        return False
    return others.retire() and others.has_retired


def _readable_error(error: Exception) -> Exception:
    if not isinstance(error, KilledWorker):
        return error
    return ParameterError(
        "a worker was killed several times, perhaps because it ran out of memory; give more"
        " memory, or fewer workers"
    )


class _Progress:
    """Progress reported so far of each task; reports after a task's end are ignored.

    Reports come in one thread of the client, the ends of tasks in another.
    """

    def __init__(self, advance: Advance) -> None:
        self._advance = advance
        self._reported: dict[int, int] = {}
        self._ended: set[int] = set()
        self._lock = threading.Lock()

    def report(self, number: int, count: int) -> None:
        """Count frames of a task that goes on."""
        with self._lock:
            if number not in self._ended:
                self._reported[number] = self._reported.get(number, 0) + count
                self._advance(count)

    def end(self, number: int, total: int) -> None:
        """Count the rest of a task."""
        with self._lock:
            self._ended.add(number)
            # A task that was begun again, after its worker was killed, has reported too much.
            self._advance(total - self._reported.get(number, 0))
