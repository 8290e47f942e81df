"""Run the tasks of a campaign; what fails is a row like any other."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeVar

import cv2
from distributed import Client, as_completed, get_worker
from distributed.scheduler import KilledWorker

from cable_tracker import __version__
from cable_tracker.campaigns.cluster import ClusterSettings, connected
from cable_tracker.campaigns.task import Outcome, Task, TaskState, do, is_done
from cable_tracker.errors import CableTrackerError, OutputError, ParameterError

PROGRESS = "cable_tracker progress"
"""Topic on which workers tell of their progress."""

TELL_EVERY = 0.5
"""Workers tell no more often [s]."""

Result_co = TypeVar("Result_co", covariant=True)
Result = TypeVar("Result")


class Work(Protocol[Result_co]):
    """Something that gives a small result, which is sent back instead of written."""

    def run(self, advance: Callable[[], None]) -> Result_co:
        """Do it; `advance` is to be called after each frame."""
        ...


class _Teller:
    """Tells the client of a task's progress, now and then."""

    def __init__(self) -> None:
        self._count = 0
        self._last = time.monotonic()

    def __call__(self, count: int = 1) -> None:
        self._count += count
        if time.monotonic() - self._last >= TELL_EVERY:
            self.tell()

    def tell(self) -> None:
        if self._count:
            get_worker().log_event(PROGRESS, self._count)
        self._count, self._last = 0, time.monotonic()


def _do_in_worker(task: Task, root: str, version: str) -> str:
    """Do a task in a worker; return why it failed, or an empty text."""
    if version != __version__:
        return _other_version(version)
    cv2.setNumThreads(1)
    teller = _Teller()
    try:
        do(task, Path(root), version, teller)
    except CableTrackerError as error:
        return str(error)
    finally:
        teller.tell()
    return ""


def _other_version(version: str) -> str:
    return (
        f"the worker has cable_tracker {__version__}, the campaign {version}; install one version"
        " on all workers"
    )


def run_campaign(
    tasks: Sequence[Task],
    root: Path,
    settings: ClusterSettings,
    *,
    resume: bool = False,
    advance: Callable[[int], None] = lambda count: None,
    finished: Callable[[Outcome], None] = lambda outcome: None,
) -> list[Outcome]:
    """Run tasks, each of which leaves a folder with its name.

    Parameters
    ----------
    tasks : sequence of Task
        What to do.
    root : Path
        Where their folders go; with workers on other machines, on a disk that all of them share.
    settings : ClusterSettings
        Where they run. One worker and no scheduler: in this process.
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
    names = [task.name for task in tasks]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ParameterError(f"two recordings are called {', '.join(twice)}; rename one of them")
    try:
        root.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{root}: cannot be written ({error.strerror})") from error
    outcomes: dict[str, Outcome] = {}

    def end(outcome: Outcome) -> None:
        outcomes[outcome.name] = outcome
        finished(outcome)

    left = []
    for task in tasks:
        if resume and is_done(task, root / task.name, __version__):
            end(Outcome(task.name, TaskState.KEPT))
        else:
            shutil.rmtree(root / task.name, ignore_errors=True)
            left.append(task)
    if settings.scheduler is None and (settings.workers == 1 or len(left) <= 1):
        for task in left:
            end(_do_here(task, root, advance))
    elif left:
        with connected(settings) as client:
            _run_on(client, left, root, (advance, end))
    return [outcomes[name] for name in names]


def _do_here(task: Task, root: Path, advance: Callable[[int], None]) -> Outcome:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        do(task, root, __version__, advance)
    except CableTrackerError as error:
        return Outcome(task.name, TaskState.FAILED, str(error))
    finally:
        cv2.setNumThreads(threads)
    return Outcome(task.name, TaskState.DONE)


def _run_on(
    client: Client,
    tasks: Sequence[Task],
    root: Path,
    tell: tuple[Callable[[int], None], Callable[[Outcome], None]],
) -> None:
    advance, end = tell
    client.subscribe_topic(PROGRESS, lambda event: advance(int(event[1])))
    futures = {
        client.submit(_do_in_worker, task, str(root.resolve()), __version__, pure=False): task
        for task in tasks
    }
    try:
        for future in as_completed(futures):
            end(_outcome(future, futures[future].name, root))
    finally:
        client.cancel(list(futures))
        client.unsubscribe_topic(PROGRESS)


def _outcome(future: Any, name: str, root: Path) -> Outcome:  # noqa: ANN401  Dask has no types.
    error = future.exception()
    if isinstance(error, KilledWorker):
        reason = "its worker was ended several times, perhaps for want of memory; give more memory"
    elif error is not None:
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
    else:
        reason = str(future.result())
    if not reason and not (root / name).is_dir():
        reason = f"its result is not in {root}; workers on other machines must share this folder"
    return Outcome(name, TaskState.FAILED if reason else TaskState.DONE, reason)


def _work_in_worker(work: Work[Result], version: str) -> Result:
    if version != __version__:
        raise ParameterError(_other_version(version))
    cv2.setNumThreads(1)
    teller = _Teller()
    try:
        return work.run(lambda: teller(1))
    finally:
        teller.tell()


def run_all(
    works: Sequence[Work[Result]],
    *,
    settings: ClusterSettings,
    advance: Callable[[int], None] = lambda count: None,
) -> list[Result]:
    """Do all of some work, and return the results in order; the first error ends it.

    Raises
    ------
    ParameterError
        The cluster cannot be used, or a worker was ended again and again.
    CableTrackerError
        What stopped the first that failed.
    """
    if settings.scheduler is None and (settings.workers == 1 or len(works) <= 1):
        return [work.run(lambda: advance(1)) for work in works]
    with connected(settings) as client:
        client.subscribe_topic(PROGRESS, lambda event: advance(int(event[1])))
        futures = [client.submit(_work_in_worker, each, __version__, pure=False) for each in works]
        try:
            for future in as_completed(futures):
                error = future.exception()
                if isinstance(error, KilledWorker):
                    raise ParameterError(
                        "workers: a process was ended several times from outside, perhaps for want"
                        " of memory; try fewer"
                    ) from error
                if error is not None:
                    raise error
            return [future.result() for future in futures]
        finally:
            client.cancel(futures)
            client.unsubscribe_topic(PROGRESS)
