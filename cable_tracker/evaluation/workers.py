"""Tasks on several processors."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from ctypes import c_longlong
from multiprocessing.sharedctypes import Synchronized
from typing import Protocol, TypeVar

import cv2

from cable_tracker.errors import ParameterError

POLL_SECONDS = 0.2
LARGEST_WORKER_COUNT = 256

Result_co = TypeVar("Result_co", covariant=True)
Result = TypeVar("Result")


class Task(Protocol[Result_co]):
    """What one process does at a time. It is sent to other processes, and so is its result."""

    def run(self, advance: Callable[[], None]) -> Result_co:
        """Do it; `advance` is to be called after each frame."""
        ...


class _Worker:
    """What a worker process keeps: the counter of frames that all share."""

    counter: Synchronized[int] | None = None

    @classmethod
    def begin(cls, counter: Synchronized[int]) -> None:
        cls.counter = counter
        cv2.setNumThreads(1)

    @classmethod
    def count(cls) -> None:
        assert cls.counter is not None
        with cls.counter.get_lock():
            cls.counter.value += 1


def _run_in_worker(task: Task[Result]) -> Result:
    return task.run(_Worker.count)


def run_tasks(
    tasks: Sequence[Task[Result]],
    *,
    workers: int = 1,
    advance: Callable[[int], None] = lambda frames: None,
) -> list[Result]:
    """Do all tasks.

    Parameters
    ----------
    tasks : sequence of Task
        What to do.
    workers : int
        Number of processes; with 1, everything happens in this one.
    advance : callable
        Told now and then how many more frames are done.

    Returns
    -------
    list
        The result of each task, in their order.

    Raises
    ------
    ParameterError
        The number of workers is out of range.
    CableTrackerError
        What stopped the first task that failed.
    """
    if not 1 <= workers <= LARGEST_WORKER_COUNT:
        raise ParameterError(f"workers is {workers}: give 1 to {LARGEST_WORKER_COUNT}")
    if workers == 1 or len(tasks) == 1:
        return _run_here(tasks, advance)
    return _run_in_pool(tasks, min(workers, len(tasks)), advance)


def _run_here(tasks: Sequence[Task[Result]], advance: Callable[[int], None]) -> list[Result]:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return [task.run(lambda: advance(1)) for task in tasks]
    finally:
        cv2.setNumThreads(threads)


def _run_in_pool(
    tasks: Sequence[Task[Result]], workers: int, advance: Callable[[int], None]
) -> list[Result]:
    # Forked copies of a process that has used OpenCV's threads may hang.
    context = multiprocessing.get_context("spawn")
    counter: Synchronized[int] = context.Value(c_longlong, 0)
    pool = ProcessPoolExecutor(workers, context, _Worker.begin, (counter,))
    try:
        futures = [pool.submit(_run_in_worker, task) for task in tasks]
        _watch(futures, counter, advance)
        return [future.result() for future in futures]
    except BrokenProcessPool as error:
        raise ParameterError(
            f"workers: one of {workers} processes was ended from outside, perhaps for want of"
            " memory; try fewer"
        ) from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _watch(
    futures: Sequence[Future[Result]],
    counter: Synchronized[int],
    advance: Callable[[int], None],
) -> None:
    """Wait for all, tell of the progress, and raise what the first one to fail has raised."""
    reported, pending = 0, set(futures)
    while pending:
        done, pending = wait(pending, timeout=POLL_SECONDS, return_when=FIRST_COMPLETED)
        count = counter.value
        advance(count - reported)
        reported = count
        for future in done:
            future.result()
