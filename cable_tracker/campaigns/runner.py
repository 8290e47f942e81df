"""Run the tasks of a campaign, on a cluster of Dask where there is more than one worker."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from distributed import Future, as_completed, get_worker
from distributed.scheduler import KilledWorker

from cable_tracker import __version__
from cable_tracker.campaigns.cluster import OtherVersions, connected
from cable_tracker.campaigns.folder_tasks import (
    FolderTask,
    Outcome,
    TaskState,
    is_done,
    is_marked,
    is_result,
    run_in_folder,
)
from cable_tracker.campaigns.result_tasks import ResultTask, run_and_keep
from cable_tracker.campaigns.settings import CampaignSettings, ClusterSettings
from cable_tracker.errors import CableTrackerError, ParameterError, one_line, write_failure
from cable_tracker.libraries import one_thread

PROGRESS = "cable_tracker progress"
"""Topic on which workers tell of their progress."""

TELL_EVERY = 0.5
"""Workers tell no more often [s]."""

MOST_REFUSALS = 3
"""Number of times that a task is given to the workers anew; each time others have come between."""

Result = TypeVar("Result")


class _Teller:
    """Tells the client of a task's progress, now and then."""

    def __init__(self, number: int) -> None:
        self._number = number
        self.total = 0
        self._count = 0
        self._last = time.monotonic()

    def __call__(self, count: int) -> None:
        self.total += count
        self._count += count
        if time.monotonic() - self._last >= TELL_EVERY:
            self.tell()

    def tell(self) -> None:
        if self._count:
            get_worker().log_event(PROGRESS, (self._number, self._count))
        self._count, self._last = 0, time.monotonic()


class _Ended(NamedTuple):
    """A task that has ended: its number, and its result, or what was raised."""

    number: int
    result: Any = None
    error: BaseException | None = None


REFUSAL = "the worker has cable_tracker "
"""Beginning of what a worker of another version says of each task. All versions say it so."""


def _in_worker(work: Callable[[_Teller], Result], number: int, version: str) -> tuple[Result, int]:
    """Do a task in a worker; return its result, and how many frames it had."""
    if version != __version__:
        raise ParameterError(
            f"{REFUSAL}{__version__}, the campaign {version}; install one version on all workers"
        )
    teller = _Teller(number)
    with one_thread():
        return work(teller), teller.total


def run_folder_tasks(
    tasks: Sequence[FolderTask],
    root: Path,
    settings: ClusterSettings,
    *,
    resume: bool = False,
    advance: Callable[[int], None] = lambda count: None,
    finished: Callable[[Outcome], None] = lambda outcome: None,
) -> list[Outcome]:
    """Run tasks, each of which leaves a folder with its name; one that fails ends no other.

    An earlier result stays until the new one is complete, and where its task fails now; then the
    outcome says so.

    Parameters
    ----------
    root : Path
        Folder of the tasks' folders; with workers on other machines, on a shared disk.
    settings : ClusterSettings
        Machines that run the tasks. One worker and no scheduler: this process.
    resume : bool
        Keep what is there of the same input, parameters and version.
    advance : callable
        Told now and then how many more frames are done.
    finished : callable
        Told of each task that has ended.

    Returns
    -------
    list of Outcome
        One for each task, in their order.

    Raises
    ------
    ParameterError
        Two tasks have one name, or the cluster cannot be used.
    OutputError
        The folder cannot be made.
    """
    _make_root(root, tasks)
    outcomes: dict[str, Outcome] = {}

    def end(outcome: Outcome) -> None:
        outcomes[outcome.name] = outcome
        finished(outcome)

    left = []
    for task in tasks:
        if resume and is_done(task, root / task.name, __version__):
            end(Outcome(task.name, TaskState.KEPT))
        else:
            left.append(task)
    if settings.is_here(len(left)):
        for task in left:
            end(_do_here(task, root, advance))
    elif left:
        calls = [partial(run_in_folder, task, root.resolve(), __version__) for task in left]
        with closing(_as_they_end(settings, calls, advance)) as ended:
            for each in ended:
                end(_outcome(each, left[each.number].name, root))
    return [outcomes[task.name] for task in tasks]


def _make_root(root: Path, tasks: Sequence[FolderTask]) -> None:
    """Make the folder of the tasks' folders, unless two of these would have one name."""
    names = [task.name for task in tasks]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ParameterError(f"two recordings are called {', '.join(twice)}; rename one of them")
    try:
        root.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise write_failure(root, error) from error


def _do_here(task: FolderTask, root: Path, advance: Callable[[int], None]) -> Outcome:
    try:
        with one_thread():
            ended = _Ended(0, run_in_folder(task, root, __version__, advance))
    # One that fails ends no other, whatever goes wrong; so it is with workers.
    except Exception as error:  # noqa: BLE001
        ended = _Ended(0, error=error)
    return _outcome(ended, task.name, root)


def _outcome(ended: _Ended, name: str, root: Path) -> Outcome:
    """Return what came of a task, whose result is the fingerprint in the marker of its folder."""
    error = ended.error
    if isinstance(error, KilledWorker):
        reason = "its worker was ended several times, perhaps for want of memory; give more memory"
    elif isinstance(error, CableTrackerError):
        reason = str(error)
    elif error is not None:
        reason = f"{type(error).__name__}: {one_line(error)}"
    # An earlier result may lie here, where a worker has put its own elsewhere.
    elif not is_marked(root / name, ended.result, __version__):
        reason = f"its result is not in {root}; workers on other machines must share this folder"
    else:
        return Outcome(name, TaskState.DONE)
    if is_result(root / name):
        reason += f"; its earlier results stay in the folder {name} and do not count here"
    return Outcome(name, TaskState.FAILED, reason)


def _as_they_end(
    settings: ClusterSettings,
    calls: Sequence[Callable[[_Teller], object]],
    advance: Callable[[int], None],
) -> Generator[_Ended]:
    """Let workers do tasks, each a call that is given what tells its progress; yield what ended.

    What a worker of another version has refused is done by others, as long as there are any. When
    the generator is closed, what has not ended is given up.
    """
    progress = _Progress(advance)
    refusals = Counter[int]()
    with connected(settings) as client:
        client.subscribe_topic(PROGRESS, lambda event: progress.tell(*event[1]))
        others = OtherVersions(client, __version__, settings.tell)

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
                    yield _Ended(number, result)
                elif refusals[number] < MOST_REFUSALS and _is_for_others(error, others):
                    refusals[number] += 1
                    again = submit(number)
                    futures[again] = number
                    ended.add(again)
                else:
                    yield _Ended(number, error=error)
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


class _Progress:
    """Progress reported so far of each task; reports after a task's end are ignored.

    Tasks tell in a thread of the client, and their end comes in another.
    """

    def __init__(self, advance: Callable[[int], None]) -> None:
        self._advance = advance
        self._told: dict[int, int] = {}
        self._ended: set[int] = set()
        self._lock = threading.Lock()

    def tell(self, number: int, count: int) -> None:
        """Count frames of a task that goes on."""
        with self._lock:
            if number not in self._ended:
                self._told[number] = self._told.get(number, 0) + count
                self._advance(count)

    def end(self, number: int, total: int) -> None:
        """Count the rest of a task."""
        with self._lock:
            self._ended.add(number)
            # A task that was begun again, after its worker was killed, has told too much.
            self._advance(total - self._told.get(number, 0))


def run_on_cluster(
    tasks: Sequence[ResultTask[Result]],
    settings: CampaignSettings,
    advance: Callable[[int], None],
) -> list[Result]:
    """Run tasks whose results come back; see `result_tasks.run_all`."""
    calls = [partial(run_and_keep, task, store=settings.store) for task in tasks]
    results: dict[int, Result] = {}
    with closing(_as_they_end(settings.cluster, calls, advance)) as ended:
        for each in ended:
            _raise_what_stopped(each.error)
            results[each.number] = each.result
    return [results[number] for number in range(len(tasks))]


def _raise_what_stopped(error: BaseException | None) -> None:
    if isinstance(error, KilledWorker):
        raise ParameterError(
            "workers: a process was ended several times from outside, perhaps for want of memory;"
            " try fewer"
        ) from error
    if error is not None:
        raise error
