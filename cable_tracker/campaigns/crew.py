"""The workers of a campaign: this process, processes of this machine, or a cluster.

Results are small and come back to the caller; with a store they also stay on the disk, so that a
campaign that was ended can go on.
"""

from __future__ import annotations

import hashlib
import io
import pickle
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any, Protocol, TypeVar

from cable_tracker import __version__
from cable_tracker.atomic_output import atomic_file
from cable_tracker.campaigns.stopping import saying_what_stays
from cable_tracker.errors import ParameterError, ResourceError, write_failure
from cable_tracker.libraries import one_thread

LARGEST_WORKER_COUNT = 256

DASHBOARD = "127.0.0.1:8787"
"""Address at which Dask serves its pages, if it is asked to."""

STORE = "tasks"
"""Folder with the results of single tasks, in the folder of a campaign."""

ARRAYS = {
    ("numpy", "ndarray"),
    ("numpy", "dtype"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy.core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy.core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
    ("numpy.core.numeric", "_frombuffer"),
}
"""Classes that stored results may be made of besides those of this package."""

Result_co = TypeVar("Result_co", covariant=True)
Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class ClusterSettings:
    """Where tasks run.

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

    Raises
    ------
    ParameterError
        The number of workers is out of range.
    """

    workers: int = 1
    scheduler: str | None = None
    memory: str = "4 GiB"
    dashboard: bool = False

    def __post_init__(self) -> None:
        if not 1 <= self.workers <= LARGEST_WORKER_COUNT:
            raise ParameterError(f"workers is {self.workers}: give 1 to {LARGEST_WORKER_COUNT}")

    def is_here(self, count: int) -> bool:
        """Tell whether tasks are done in this process."""
        return self.scheduler is None and (self.workers == 1 or count <= 1)


class Work(Protocol[Result_co]):
    """Something that gives a small result, which is sent back. It is sent to other processes."""

    def run(self, advance: Callable[[], None]) -> Result_co:
        """Do it; `advance` is to be called after each frame."""
        ...


@dataclass(frozen=True, slots=True)
class Crew:
    """The workers of a campaign, and where its results are kept.

    Attributes
    ----------
    settings : ClusterSettings
        Where it is done.
    store : Path or None
        Folder for the result of each work; None: they are not kept.
    resume : bool
        Take from the store what is there of the same work and version.
    """

    settings: ClusterSettings
    store: Path | None = None
    resume: bool = False


Workers = int | Crew
"""Number of processes of this machine, or a crew."""


def crew_of(workers: Workers) -> Crew:
    """Return a crew; a number is the count of its processes on this machine.

    Raises
    ------
    ParameterError
        The number is out of range.
    """
    return workers if isinstance(workers, Crew) else Crew(ClusterSettings(workers))


def fingerprint_of(work: object) -> str:
    """Return what stands for a work and this version of the package.

    It is made of `work.fingerprint()`, or of the text that the work is written as.
    """
    own = getattr(work, "fingerprint", None)
    text = own() if own is not None else repr(work)
    return hashlib.sha256(f"{__version__} {type(work).__qualname__} {text}".encode()).hexdigest()


def do_and_keep(work: Work[Result], advance: Callable[[], None], store: Path | None) -> Result:
    """Do some work, and keep its result.

    Raises
    ------
    OutputError
        The result cannot be written.
    """
    with one_thread():
        result = work.run(advance)
    if store is not None:
        _keep(store / fingerprint_of(work), result)
    return result


def _keep(path: Path, result: object) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_file(path, by_many=True) as part:
            part.write_bytes(pickle.dumps(result))
    except OSError as error:
        with suppress(OSError):  # Results of other tasks stay, for a campaign that goes on.
            path.parent.rmdir()
        raise write_failure(path.parent, error) from error


class _Kept(pickle.Unpickler):
    """Reads results, and nothing that could do anything."""

    def find_class(self, module: str, name: str) -> Any:  # noqa: ANN401
        # A name with a dot would lead on to whatever a module imports.
        is_own = module.split(".", maxsplit=1)[0] == "cable_tracker" and "." not in name
        if is_own or (module, name) in ARRAYS:
            found = super().find_class(module, name)
            if not is_own or _is_value_class(found, module):
                return found
        raise pickle.UnpicklingError(f"{module}.{name} is no part of a result")


def _is_value_class(found: object, module: str) -> bool:
    """Tell whether this is a class of a module's own that only holds values."""
    if not isinstance(found, type) or found.__module__ != module:
        return False
    is_named_tuple = issubclass(found, tuple) and hasattr(found, "_fields")
    return is_dataclass(found) or issubclass(found, Enum) or is_named_tuple


def kept_result(work: object, store: Path | None) -> tuple[Any] | None:
    """Return the result of a work that is in a store, alone in a tuple; None: it is not there."""
    if store is None:
        return None
    try:
        data = (store / fingerprint_of(work)).read_bytes()
        return (_Kept(io.BytesIO(data)).load(),)
    # A file that was cut off, or is of another version, raises what it happens to raise.
    except Exception:  # noqa: BLE001
        return None


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
    works: Sequence[Work[Result]],
    *,
    workers: Workers = 1,
    advance: Callable[[int], None] = lambda count: None,
) -> list[Result]:
    """Do all of some work, and return the results in order; the first error ends it.

    The results do not depend on the number of workers.

    Parameters
    ----------
    works : sequence of Work
        What to do.
    workers : int or Crew
        The number of processes, or a crew.
    advance : callable
        Told now and then how many more frames are done; kept results have none.

    Raises
    ------
    ParameterError
        The number of workers is out of range, the cluster cannot be used, or a worker was ended
        again and again.
    ResourceError
        Several workers are wanted, and Dask is not installed.
    CableTrackerError
        What stopped the first that failed.
    """
    crew = crew_of(workers)
    done: dict[int, Result] = {}
    if crew.resume:
        for number, work in enumerate(works):
            kept = kept_result(work, crew.store)
            if kept is not None:
                done[number] = kept[0]
    left = [number for number in range(len(works)) if number not in done]
    if crew.settings.is_here(len(left)):
        for number in left:
            done[number] = do_and_keep(works[number], lambda: advance(1), crew.store)
    elif left:
        # Dask takes a second to import, which a single process need not wait for.
        with needing_dask():
            from cable_tracker.campaigns.runner import run_on_cluster  # noqa: PLC0415

        results = run_on_cluster([works[number] for number in left], crew, advance)
        done.update(zip(left, results, strict=True))
    return [done[number] for number in range(len(works))]


@contextmanager
def stored_beside(output: Path, settings: ClusterSettings, *, resume: bool) -> Iterator[Crew]:
    """Give a crew whose results lie beside an output folder until that is complete.

    Then `move_store` puts them into it. A campaign that goes on finds them in either place.
    """
    store = output.with_name(f"{output.name}.{STORE}")
    if not resume:
        shutil.rmtree(store, ignore_errors=True)
    elif (output / STORE).is_dir():
        shutil.copytree(output / STORE, store, dirs_exist_ok=True)
    with saying_what_stays(store):
        yield Crew(settings, store.absolute(), resume)


def move_store(crew: Crew, folder: Path) -> None:
    """Put what a crew has kept into the folder of its campaign, once all is done."""
    if crew.store is not None and crew.store.is_dir():
        shutil.move(crew.store, folder / STORE)
