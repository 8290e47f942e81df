"""Output of commands, and how they show that they are at work."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

AnyFrame = TypeVar("AnyFrame")

console = Console(markup=False, highlight=False)
messages = Console(stderr=True, markup=False, highlight=False)

NARROW: Mapping[str, Any] = MappingProxyType(
    {"box": SIMPLE_HEAD, "pad_edge": False, "collapse_padding": True}
)
"""Settings of a table with many columns."""


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


def advance_to(progress: Progress, place: float) -> None:
    """Move the only task of a progress bar to a place, or to its beginning if that is before it."""
    progress.update(progress.task_ids[0], completed=max(0, round(place)))


def counted(frames: Iterable[AnyFrame], progress: Progress) -> Iterator[AnyFrame]:
    """Move the progress bar with every frame that passes."""
    for frame in frames:
        yield frame
        advance(progress)


def print_table(
    title: str,
    headings: Iterable[str],
    rows: Iterable[Iterable[str]],
    left: Container[int] = (),
    *,
    narrow: bool = False,
) -> None:
    """Print a table.

    Parameters
    ----------
    left : container of int
        Numbers of the columns that are flush left; the others are flush right.
    narrow : bool
        Leave out frames and margins, and keep each cell of the columns of `left` on one line.
    """
    table = Table(title=title, **(NARROW if narrow else {}))
    for number, heading in enumerate(headings):
        is_left = number in left
        table.add_column(
            heading,
            justify="left" if is_left else "right",
            no_wrap=narrow and is_left,
            overflow="fold",
        )
    for row in rows:
        table.add_row(*row)
    console.print(table)


def print_note(text: str) -> None:
    """Print a note for the user on stderr."""
    messages.print(f"note: {text}", soft_wrap=True)


def print_left_out(reasons: Mapping[str, str]) -> None:
    """Print which scenarios of a pattern are left out, and why; `reasons` by name."""
    for reason in dict.fromkeys(reasons.values()):
        names = [name for name, other in reasons.items() if other == reason]
        verb = "is" if len(names) == 1 else "are"
        print_note(f"{', '.join(names)} {verb} left out: {reason}")


def print_facts(title: str, facts: Iterable[tuple[str, str]]) -> None:
    """Print a table of names and values without headings."""
    print_table(title, ("", ""), facts, left=(0,))


def print_files(folder: Path, names: Iterable[str]) -> None:
    """Print which files a command has written into a folder."""
    for name in names:
        console.print(f"  {folder / name}", soft_wrap=True)
