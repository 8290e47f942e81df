"""Output of commands, and how they show that they are at work."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from cable_tracker.sequences.frame import Frame

console = Console(markup=False, highlight=False)
messages = Console(stderr=True, markup=False, highlight=False)


@contextmanager
def progress_bar(description: str, total: int | None) -> Iterator[Progress]:
    """Show a progress bar on the terminal; nothing where there is none."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    hidden = not messages.is_terminal
    progress = Progress(*columns, console=messages, transient=True, disable=hidden)
    progress.add_task(description, total=total)
    # Off a terminal the bar would leave an empty line among the messages, with Rich 13 even a
    # disabled one that is started and stopped.
    with nullcontext() if hidden else progress:
        yield progress


def advance(progress: Progress, count: int = 1) -> None:
    """Move the only task of a progress bar."""
    progress.advance(progress.task_ids[0], count)


def counted(frames: Iterable[Frame], progress: Progress) -> Iterator[Frame]:
    """Move the progress bar with every frame that passes."""
    for frame in frames:
        yield frame
        advance(progress)
