"""Files that stay on the disk when a campaign is stopped."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cable_tracker.campaigns.folder_tasks import MARKER


def finished_tasks(place: Path) -> int:
    """Count what a campaign that goes on need not do again: folders of tasks, and results."""
    folders = sum(1 for _ in place.glob(f"*/{MARKER}"))
    return folders + sum(1 for each in place.glob("[!.]*") if each.is_file())


@contextmanager
def saying_what_stays(place: Path) -> Iterator[None]:
    """Add a note to what stops the work inside, if tasks in a folder are finished by then.

    Signals stop it. Errors say themselves what is wrong, and get no note.
    """
    try:
        yield
    except Exception:
        raise
    except BaseException as stop:
        count = finished_tasks(place)
        if count:
            tasks = "1 finished task is" if count == 1 else f"{count} finished tasks are"
            stop.add_note(f"{tasks} kept in {place}; --resume goes on from there")
        raise
