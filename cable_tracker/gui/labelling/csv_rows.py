"""Reading of the CSV files that lie beside a label file."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from cable_tracker.errors import RecordingError, one_line

T = TypeVar("T")


def read_rows(path: Path, header: Sequence[str], parse: Callable[[list[str]], T]) -> list[T]:
    """Return the parsed rows below the header of a CSV file; empty if there is no file.

    Parameters
    ----------
    header : sequence of str
        Names of the columns, which the first line must be.
    parse : callable
        Turns the fields of a row into its meaning; raises ValueError if they have none.

    Raises
    ------
    RecordingError
        The file cannot be read, or a line is malformed; the message names it.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
    except FileNotFoundError:
        return []
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(
            f"{path}: cannot be read ({one_line(error)}); check or remove the file"
        ) from error
    wanted = ",".join(header)
    if not rows or rows[0] != list(header):
        raise RecordingError(
            f"{path}: line 1 is not the header {wanted}; correct or remove the file"
        )
    parsed = []
    for number, fields in enumerate(rows[1:], start=2):
        try:
            parsed.append(_parsed(fields, len(header), parse))
        except ValueError as error:
            raise RecordingError(
                f"{path}: line {number} is malformed ({one_line(error)}); expected: {wanted};"
                " correct it, or remove the file"
            ) from error
    return parsed


def _parsed(fields: list[str], count: int, parse: Callable[[list[str]], T]) -> T:
    if len(fields) != count:
        raise ValueError(f"{len(fields)} fields instead of {count}")
    return parse(fields)
