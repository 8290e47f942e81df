"""Sort file names as a person would: frame_9 before frame_10."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

LONGEST_GAP = 10_000
"""Largest number of missing numbers at one place of names that count frames."""


def natural_key(path: Path) -> tuple[tuple[tuple[int, int, str], ...], str]:
    """Return a sort key by the file's name, in which runs of digits count as numbers."""
    parts = re.split(r"([0-9]+)", path.name)
    numbers = tuple(
        (0, int(part), "") if part.isdecimal() else (1, 0, part) for part in parts if part
    )
    return numbers, path.name


def positions_by_number(names: Sequence[str]) -> list[int]:
    """Return where each of some names stands in the series that their numbers count.

    Names count where they differ in one run of digits alone, which grows, in steps that are all
    multiples of the smallest and at most `LONGEST_GAP` of it. A missing number is then a gap in
    the series; names of any other kind stand one after the other.

    Parameters
    ----------
    names : sequence of str
        In natural order.
    """
    successive = list(range(len(names)))
    split = [re.split(r"([0-9]+)", Path(name).stem) for name in names]
    if len(split) < 3 or len({len(parts) for parts in split}) > 1:
        return successive
    varying = [place for place, parts in enumerate(zip(*split, strict=True)) if len(set(parts)) > 1]
    if len(varying) != 1 or varying[0] % 2 == 0:
        return successive
    numbers = [int(parts[varying[0]]) for parts in split]
    steps = [after - before for before, after in pairwise(numbers)]
    smallest = min(steps)
    if smallest < 1 or max(steps) > LONGEST_GAP * smallest or any(s % smallest for s in steps):
        return successive
    return [(number - numbers[0]) // smallest for number in numbers]


def gap_note(names: Sequence[str], positions: Sequence[int]) -> str:
    """Say which numbers are missing between names, by their `positions_by_number`; empty: none."""
    missing = positions[-1] + 1 - len(positions)
    if not missing:
        return ""
    first = next(
        names[index]
        for index, (before, after) in enumerate(pairwise(positions))
        if after > before + 1
    )
    return (
        f"{missing} pictures are missing by their numbers, the first after {first}; the others keep"
        " the time that their numbers say. If they are successive all the same, number them without"
        " gaps"
    )
