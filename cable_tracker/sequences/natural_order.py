"""Sort file names as a person would: frame_9 before frame_10."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

LONGEST_GAP = 10_000
"""Largest number of missing numbers at one place of names that count frames."""


_DIGITS = re.compile("([0-9]+)")
_DECIMAL = re.compile(r"(?<![0-9])(?<![0-9]\.)([0-9]+\.)([0-9]+)(?![0-9])(?!\.[0-9])")
"""Two runs of digits with a point between them, and no third one with another point."""


def naturally_sorted(paths: Iterable[Path]) -> list[Path]:
    """Return paths in the order of their names, in which runs of digits count as numbers.

    A number with one point, as in `frame_9.5` or `1699999999.25`, may be a decimal, or two numbers:
    a part and a count. It is a decimal where the names have differing numbers of decimals, differ
    before the point too, and none ends with a zero, as decimals do that are not padded: 9.25 comes
    before 9.5. A count of that kind comes to 10 sooner or later, that of a single part (`dive1.87`)
    has the same number before it, and nanoseconds without their zeros end with one: then 9.5 comes
    before 9.25. With equally many decimals both are the same. Numbers with several points, as
    `v1.2.10`, are versions, and no decimals.

    Parameters
    ----------
    paths : iterable of Path
        All that are to be in one order, for the names tell together how they are meant.
    """
    given = list(paths)
    aligned = _aligned([path.name for path in given])
    keys = {path: _key(name) for path, name in zip(given, aligned, strict=True)}
    return sorted(given, key=lambda path: (keys[path], path.name))


def _key(name: str) -> tuple[tuple[int, int, str], ...]:
    parts = _DIGITS.split(name)
    return tuple((0, int(part), "") if part.isdecimal() else (1, 0, part) for part in parts if part)


def _aligned(names: Sequence[str]) -> list[str]:
    """Return names in which all decimals have equally many places; else they are as they were."""
    found = [match.groups() for name in names for match in _DECIMAL.finditer(name)]
    lengths = {len(fraction) for _, fraction in found}
    is_part_fixed = len({part for part, _ in found}) < 2
    is_counted = any(len(fraction) > 1 and fraction.endswith("0") for _, fraction in found)
    if len(lengths) < 2 or is_part_fixed or is_counted:
        return list(names)
    longest = max(lengths)
    return [_DECIMAL.sub(lambda match: match[1] + match[2].ljust(longest, "0"), n) for n in names]


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
    split = [_DIGITS.split(Path(name).stem) for name in names]
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
