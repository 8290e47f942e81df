"""Let the workers of a cluster of Dask do the tasks of a campaign."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from typing import TypeVar

from distributed import Future, as_completed, get_worker
from distributed.scheduler import KilledWorker

from cable_tracker import __version__
from cable_tracker.campaigns.cluster import OtherVersions, connected
from cable_tracker.campaigns.runner import Advance, Ended
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.errors import CableTrackerError, ParameterError
from cable_tracker.libraries import one_thread

PROGRESS = "cable_tracker progress"
"""Topic on which workers report their progress."""

REPORT_EVERY = 0.5
"""Least time between two reports of a worker [s]."""

MOST_REFUSALS = 3
"""Number of times that a task is given to the workers anew; each time others have come between."""

Result = TypeVar("Result")


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
