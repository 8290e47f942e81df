"""Tasks whose results are small and come back to the caller.

They run in this process, in processes of this machine, or on a cluster of Dask.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol, TypeVar

from cable_tracker.campaigns.result_store import fingerprint_of, keep_result, kept_result
from cable_tracker.campaigns.settings import HERE, CampaignSettings
from cable_tracker.errors import ResourceError
from cable_tracker.libraries import one_thread

Result_co = TypeVar("Result_co", covariant=True)
Result = TypeVar("Result")


class ResultTask(Protocol[Result_co]):
    """Unit of work of one worker, with a result. It is pickled to other processes."""

    def run(self, advance: Callable[[int], None]) -> Result_co:
        """Do it; `advance` is to be told how many more frames are done."""
        ...


def run_and_keep(
    task: ResultTask[Result], advance: Callable[[int], None], store: Path | None
) -> Result:
    """Do a task, and keep its result if there is a store.

    It is kept as that of the files as they were at the beginning: what is written to while the task
    runs, as labels that are corrected, is done again next time.

    Raises
    ------
    OutputError
        The result cannot be written.
    """
    fingerprint = "" if store is None else fingerprint_of(task)
    result = task.run(advance)
    if store is not None:
        keep_result(fingerprint, result, store)
    return result


@contextmanager
def needing_dask() -> Iterator[None]:
    """Import what needs Dask, which a system with ROS may lack.

    Raises
    ------
    ResourceError
        It is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise ResourceError(
            f"several runs at once need Dask (no module {error.name}); run `pip install dask"
            " distributed`, or give --workers 1"
        ) from error


def run_all(
    tasks: Sequence[ResultTask[Result]],
    settings: CampaignSettings = HERE,
    *,
    advance: Callable[[int], None] = lambda count: None,
) -> list[Result]:
    """Run tasks, and return their results in order; the first error ends it.

    The results do not depend on the number of workers.

    Parameters
    ----------
    settings : CampaignSettings
        Machines that run the tasks, and the folder of results.
    advance : callable
        Told now and then how many more frames are done; kept results have none.

    Raises
    ------
    ParameterError
        The cluster cannot be used, or a worker was ended
        again and again.
    ResourceError
        Several workers are wanted, and Dask is not installed.
    CableTrackerError
        What stopped the first that failed.
    """
    done: dict[int, Result] = {}
    if settings.resume:
        for number, task in enumerate(tasks):
            kept = kept_result(task, settings.store)
            if kept is not None:
                done[number] = kept[0]
    left = [number for number in range(len(tasks)) if number not in done]
    if settings.cluster.is_here(len(left)):
        with one_thread():
            for number in left:
                done[number] = run_and_keep(tasks[number], advance, settings.store)
    elif left:
        # Dask takes a second to import, which a single process need not wait for.
        with needing_dask():
            from cable_tracker.campaigns.runner import run_on_cluster  # noqa: PLC0415

        results = run_on_cluster([tasks[number] for number in left], settings, advance)
        done.update(zip(left, results, strict=True))
    return [done[number] for number in range(len(tasks))]
