"""Tables as comma-separated values, as this package writes them."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import TextIO


def csv_text(headings: Iterable[object], rows: Iterable[Iterable[object]]) -> str:
    """Return a table, one line for the headings and one for each row.

    Lines end with a line feed alone. Cells are written by `str`; those that hold commas, quotation
    marks or line feeds are quoted.
    """
    text = io.StringIO()
    _write(text, headings, rows)
    return text.getvalue()


def write_csv(path: Path, headings: Iterable[object], rows: Iterable[Iterable[object]]) -> None:
    """Write a table into a file, row by row; see `csv_text`.

    Letters of names that are not UTF-8 become ?.
    """
    with path.open("w", newline="", encoding="utf-8", errors="replace") as file:
        _write(file, headings, rows)


def write_records(path: Path, kind: type, records: Iterable[object]) -> None:
    """Write dataclasses of one kind, a column for each field; cells as of `format_cell`."""
    names = [field.name for field in fields(kind)]
    rows = ([format_cell(getattr(record, name)) for name in names] for record in records)
    write_csv(path, names, rows)


def format_cell(value: object) -> str:
    """Return a value as a cell: numbers with five decimals; what is not known is empty."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.5f}" if math.isfinite(value) else ""
    return str(value)


def _write(file: TextIO, headings: Iterable[object], rows: Iterable[Iterable[object]]) -> None:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(headings)
    writer.writerows(rows)
