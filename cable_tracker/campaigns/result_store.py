"""Results of tasks on the disk, so that a campaign that was ended can go on."""

from __future__ import annotations

import hashlib
import io
import pickle
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import is_dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

from cable_tracker import __version__
from cable_tracker.atomic_output import atomic_file, output_folder
from cable_tracker.campaigns.folder_tasks import is_result
from cable_tracker.campaigns.settings import CampaignSettings, ClusterSettings
from cable_tracker.errors import OutputError, write_failure

STORE = "tasks"
"""Folder with the results of single tasks, in the folder of a campaign."""

_RESULT_FILE = re.compile(r"[0-9a-f]{64}|\.[0-9a-f]{64}\.[0-9]+\.part")
_PARTIAL_FOLDER = re.compile(r"\..+\.partial")
"""Names of what tasks leave: results, whole and unfinished, and folders that are unfinished."""

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


@contextmanager
def noting_finished_tasks(place: Path, finished: Callable[[], int]) -> Iterator[None]:
    """Add a note to the exception that stops the work inside, if tasks are finished by then.

    Only signals and failures to write get the note. Other errors say themselves what is
    wrong. `finished` counts the tasks that need not be done again.
    """
    try:
        yield
    except BaseException as stop:
        if isinstance(stop, Exception) and not isinstance(stop, OutputError | OSError):
            raise
        count = finished()
        if count:
            tasks = "1 finished task is" if count == 1 else f"{count} finished tasks are"
            stop.add_note(f"{tasks} kept in {place}; --resume goes on from there")
        raise


def fingerprint_of(task: object) -> str:
    """Return a hash that identifies a task and this version of the package.

    Hashed are the version, the task's type, and `task.fingerprint()` or else its `repr`.
    """
    own = getattr(task, "fingerprint", None)
    text = own() if own is not None else repr(task)
    described = f"{__version__} {type(task).__qualname__} {text}"
    # Names of files need not be UTF-8.
    return hashlib.sha256(described.encode(errors="surrogateescape")).hexdigest()


def write_result(fingerprint: str, result: object, store: Path) -> None:
    """Write the result of a task into a store, which is made if it is not there.

    Parameters
    ----------
    fingerprint : str
        See `fingerprint_of`; taken before the task is run, for its files may be written to
        meanwhile.

    Raises
    ------
    OutputError
        The result cannot be written.
    """
    try:
        store.mkdir(parents=True, exist_ok=True)
        with (
            atomic_file(store / fingerprint, by_many=True) as part,
            part.open("wb") as file,
        ):
            _ResultPickler(file).dump(result)
    except OSError as error:
        with suppress(OSError):  # Results of other tasks stay, for a campaign that goes on.
            store.rmdir()
        raise write_failure(store, error) from error


class _ResultPickler(pickle.Pickler):
    """Writes results in a form that `_ResultUnpickler` reads."""

    def reducer_override(self, value: object) -> Any:  # noqa: ANN401
        # Python 3.11.2 by itself writes them by `getattr`, which is refused.
        return (type(value), (value.value,)) if isinstance(value, Enum) else NotImplemented


class _ResultUnpickler(pickle.Unpickler):
    """Reads results made of value classes alone: nothing that runs code."""

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


def read_result(task: object, store: Path | None) -> tuple[Any] | None:
    """Read the result of a task from a store, as a tuple of one; None: it is not there."""
    if store is None:
        return None
    try:
        data = (store / fingerprint_of(task)).read_bytes()
        return (_ResultUnpickler(io.BytesIO(data)).load(),)
    # A file that was cut off, or is of another version, raises what it happens to raise.
    except Exception:  # noqa: BLE001
        return None


def count_results(store: Path) -> int:
    """Return the number of results in a store, files and folders."""
    return sum(each.is_file() or is_result(each) for each in store.glob("[!.]*"))


@contextmanager
def stored_beside(
    output: Path, cluster: ClusterSettings, *, resume: bool
) -> Iterator[CampaignSettings]:
    """Give settings with which results lie beside an output folder until that is complete.

    A campaign that goes on finds them in either place; one
    that does not removes those of an earlier campaign that was ended.

    Raises
    ------
    OutputError
        Such results are to be removed, and something else lies among them.
    """
    store = output.with_name(f"{output.name}.{STORE}")
    if not resume:
        _remove(store)
    elif (output / STORE).is_dir():
        shutil.copytree(output / STORE, store, dirs_exist_ok=True)
    with noting_finished_tasks(store, partial(count_results, store)):
        yield CampaignSettings(cluster, store.absolute(), resume)


def _remove(store: Path) -> None:
    """Remove what an earlier campaign has left, but nothing else."""
    if not store.is_dir():
        return
    foreign = sorted(each.name for each in store.iterdir() if not _is_campaign_file(each))
    if foreign:
        raise OutputError(
            f"{store}: is to be replaced, but holds {foreign[0]}, which is no result of a task;"
            " move it away, or choose another output"
        )
    shutil.rmtree(store, ignore_errors=True)


def _is_campaign_file(path: Path) -> bool:
    """Tell whether a campaign puts a file or folder of such a name and content into its store."""
    if path.is_dir():
        return is_result(path) or _PARTIAL_FOLDER.fullmatch(path.name) is not None
    return _RESULT_FILE.fullmatch(path.name) is not None


@contextmanager
def campaign_folder(
    output: Path,
    marker: str,
    cluster: ClusterSettings,
    *,
    force: bool,
    resume: bool,
    is_own_name: Callable[[str], bool],
) -> Iterator[tuple[Path, CampaignSettings]]:
    """Give the folder of a campaign to write into, as `output_folder`, and its settings.

    The results of its tasks lie beside the folder until the context ends well, then in it.

    Parameters
    ----------
    force : bool
        Replace an earlier folder of the kind.
    resume : bool
        Go on with an earlier campaign, whose folder is replaced as well.

    Raises
    ------
    OutputError
        The path is taken, holds something else, or cannot be written.
    """
    with (
        output_folder(output, marker, overwrite=force or resume, is_own_name=is_own_name) as folder,
        stored_beside(output, cluster, resume=resume) as settings,
    ):
        yield folder, settings
        # Last: where the report is stopped, the folder goes, and with it all that lies in it.
        if settings.store is not None and settings.store.is_dir():
            shutil.move(settings.store, folder / STORE)
