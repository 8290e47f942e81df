"""Files that stay on the disk when a campaign is stopped."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from cable_tracker.errors import OutputError


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
