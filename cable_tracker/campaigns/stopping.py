"""Files that stay on the disk when a campaign is stopped."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from cable_tracker.errors import OutputError


@contextmanager
def saying_what_stays(place: Path, finished: Callable[[], int]) -> Iterator[None]:
    """Add a note to what stops the work inside, if tasks in a folder are finished by then.

    Signals stop it, and a disk that does not let us write. Other errors say themselves what is
    wrong, and get no note. `finished` counts the tasks that need not be done again.
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
