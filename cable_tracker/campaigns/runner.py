"""Run the tasks of a campaign: in this process, in processes of this machine, or on a cluster."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TypeVar

from cable_tracker import __version__
from cable_tracker.campaigns.folder_tasks import (
    FolderTask,
    Outcome,
    TaskState,
    is_done,
    is_marked,
    is_result,
    run_in_folder,
)
from cable_tracker.campaigns.result_store import fingerprint_of, read_result, write_result
from cable_tracker.campaigns.settings import HERE, CampaignSettings, ClusterSettings
from cable_tracker.errors import (
    CableTrackerError,
    ParameterError,
    ResourceError,
    one_line,
    write_failure,
)
from cable_tracker.libraries import one_thread

Result_co = TypeVar("Result_co", covariant=True)
Result = TypeVar("Result")

Advance = Callable[[int], None]
"""Called with the number of frames done since its last call."""


class Ended(NamedTuple):
    """A task that has ended: its number, and its result or the exception raised."""

    number: int
    result: Any = None
    error: Exception | None = None


class ResultTask(Protocol[Result_co]):
    """Unit of work of one worker, with a result. It is pickled to other processes."""

    def run(self, advance: Advance) -> Result_co:
        """Run the task; calls `advance` with the number of further frames done."""
        ...


def run_and_store(task: ResultTask[Result], advance: Advance, store: Path | None) -> Result:
    """Run a task, and write its result into the store if there is one.

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
        write_result(fingerprint, result, store)
    return result


def _run_calls(
    settings: ClusterSettings, calls: Sequence[Callable[[Advance], object]], advance: Advance
) -> Generator[Ended]:
    """Run `calls`, each given a function to report its progress; yield the ended tasks.

    When the generator is closed, tasks that have not ended are given up.

    Raises
    ------
    ResourceError
        Several workers are wanted, and Dask is not installed: a system with ROS may lack it.
    """
    if settings.is_here(len(calls)):
        for number, call in enumerate(calls):
            yield _do_here(number, call, advance)
    elif calls:
        # Dask takes a second to import, which a single process need not wait for.
        try:
            from cable_tracker.campaigns.cluster import run_on_cluster  # noqa: PLC0415
        except ModuleNotFoundError as error:
            raise ResourceError(
                f"several runs at once need Dask (no module {error.name}); run `pip install dask"
                " distributed`, or give --workers 1"
            ) from error
        with closing(run_on_cluster(settings, calls, advance)) as ended:
            yield from ended


def _do_here(number: int, call: Callable[[Advance], object], advance: Advance) -> Ended:
    try:
        with one_thread():
            return Ended(number, call(advance))
    # Whether it ends other tasks is for the caller to say; so it is with workers.
    except Exception as error:  # noqa: BLE001
        return Ended(number, error=error)


def run_all(
    tasks: Sequence[ResultTask[Result]],
    settings: CampaignSettings = HERE,
    *,
    advance: Advance = lambda count: None,
) -> list[Result]:
    """Run tasks, and return their results in order; the first error ends it.

    The results do not depend on the number of workers.

    Parameters
    ----------
    settings : CampaignSettings
        Machines that run the tasks, and the folder of results.
    advance : callable
        Called with the number of frames done since its last call; kept results have none.

    Raises
    ------
    ParameterError
        The cluster cannot be used, or a worker was ended again and again.
    ResourceError
        Several workers are wanted, and Dask is not installed.
    CableTrackerError
        Error of the first task that failed.
    """
    done: dict[int, Result] = {}
    if settings.resume:
        for number, task in enumerate(tasks):
            kept = read_result(task, settings.store)
            if kept is not None:
                done[number] = kept[0]
    left = [number for number in range(len(tasks)) if number not in done]
    calls = [partial(run_and_store, tasks[number], store=settings.store) for number in left]
    with closing(_run_calls(settings.cluster, calls, advance)) as ended:
        for each in ended:
            if each.error is not None:
                raise each.error
            done[left[each.number]] = each.result
    return [done[number] for number in range(len(tasks))]


def run_folder_tasks(
    tasks: Sequence[FolderTask],
    root: Path,
    settings: ClusterSettings,
    *,
    resume: bool = False,
    advance: Advance = lambda count: None,
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
        Called with the number of frames done since its last call.
    finished : callable
        Called with the outcome of each task that has ended.

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
    ResourceError
        Several workers are wanted, and Dask is not installed.
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
    # Workers need not be in this folder.
    place = root if settings.is_here(len(left)) else root.resolve()
    calls = [partial(run_in_folder, task, place, __version__) for task in left]
    with closing(_run_calls(settings, calls, advance)) as ended:
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


def _outcome(ended: Ended, name: str, root: Path) -> Outcome:
    """Return the outcome of a task, whose result is the fingerprint in its folder's marker."""
    error = ended.error
    if isinstance(error, CableTrackerError):
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
