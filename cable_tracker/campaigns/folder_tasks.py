"""Tasks whose results are folders, and how it is known whether one has been done already."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Protocol

from cable_tracker.atomic_output import holds, output_file

MARKER = "task.json"
"""Lies in the folder of a task that is done, and says of what."""


class FolderTask(Protocol):
    """Unit of work of one worker. It is pickled to other processes, perhaps on other machines.

    Attributes
    ----------
    name : str
        Name of the folder that its results go to; each task of a campaign has its own.
    """

    @property
    def name(self) -> str:
        """Name of the folder that its results go to."""
        ...

    def fingerprint(self) -> str:
        """Return a text that changes when input or parameters change."""
        ...

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        """Run the task, write all results into an existing folder, and report the progress."""
        ...

    def is_own_name(self, name: str) -> bool:
        """Tell whether it writes a file of this name; others are the user's, and are kept."""
        ...


class TaskState(str, Enum):
    """State of a task."""

    DONE = "done"
    KEPT = "kept"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Outcome:
    """Outcome of a task.

    Attributes
    ----------
    name : str
        Name of the task.
    state : TaskState
        KEPT: an earlier campaign has done it already.
    reason : str
        Reason for its failure; empty if it did not fail.
    """

    name: str
    state: TaskState
    reason: str = ""


def fingerprint_of_files(*paths: Path) -> str:
    """Return a text that changes when one of some files, or a file in a folder, is written to.

    It is made of names, sizes and times of change; contents are not read.
    """
    lines = [line for path in paths for line in _facts_of_files(path)]
    # Names need not be UTF-8.
    return hashlib.sha256("\n".join(lines).encode(errors="surrogateescape")).hexdigest()


def _facts_of_files(path: Path) -> Iterator[str]:
    for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
        try:
            if file.is_dir():
                continue
            found = file.stat()
        except OSError:
            yield f"{file.name} missing"
            continue
        yield f"{file.relative_to(path.parent)} {found.st_size} {found.st_mtime_ns}"


def is_result(folder: Path) -> bool:
    """Tell whether a task has left a folder, whether or not what it holds still counts."""
    return (folder / MARKER).is_file()


def forget(folder: Path) -> None:
    """Let the results in a folder count no more; they stay results, which may be replaced."""
    if is_result(folder):
        (folder / MARKER).write_text("", encoding="utf-8")


def is_done(task: FolderTask, folder: Path, version: str) -> bool:
    """Tell whether a folder holds the results of this very task, by this very version."""
    return is_marked(folder, task.fingerprint(), version)


def is_marked(folder: Path, fingerprint: str, version: str) -> bool:
    """Tell whether a folder holds the results of a task with this fingerprint, by this version."""
    try:
        marker = json.loads((folder / MARKER).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return bool(marker == _marker(fingerprint, version))


def _marker(fingerprint: str, version: str) -> dict[str, str]:
    return {"fingerprint": fingerprint, "version": version}


def run_in_folder(
    task: FolderTask, root: Path, version: str, advance: Callable[[int], None]
) -> str:
    """Do a task; its folder appears when it is complete, in place of an earlier one.

    Where it fails, the earlier one stays: an option that was mistyped, a full disk or one that is
    not mounted is soon put right, and its marker says what it is a result of. A folder without a
    marker, which no task has left, is not replaced: it may be the recording itself. Files that are
    not of the task are carried over.

    The marker tells of the input as it was at the beginning: what was still being written then is
    done again next time.

    Returns
    -------
    str
        The fingerprint in the marker.

    Raises
    ------
    OutputError
        The results cannot be written, or something else lies in their place.
    """
    fingerprint, place = task.fingerprint(), root / task.name
    with output_file(
        place, holds(MARKER), overwrite=True, is_own_name=task.is_own_name, carries_over=True
    ) as folder:
        folder.mkdir()
        task.run(folder, advance)
        marker = json.dumps(_marker(fingerprint, version))
        (folder / MARKER).write_text(marker, encoding="utf-8")
    return fingerprint
