"""Tables of results as text, and how numbers are written in them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cable_tracker.evaluation.sample_statistics import Spread
from cable_tracker.sequences.tables.csv_tables import csv_text

TABLE_CSV = "table.csv"


@dataclass(frozen=True, slots=True)
class ResultTable:
    """One table of results.

    Attributes
    ----------
    headings : tuple of str
        Headings with units.
    rows : tuple of tuple of str
        Rows with as many cells each as there are headings.
    title : str
        Title of the table; empty if there is only this table.
    file_name : str
        Name of the CSV file.
    notes : tuple of str
        Notes below the table, in Markdown, one item of a list each.
    brief : int or None
        Number of columns that fit on a terminal; None: all.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    title: str = ""
    file_name: str = TABLE_CSV
    notes: tuple[str, ...] = ()
    brief: int | None = None


def table_csv(table: ResultTable) -> str:
    """Return a table as CSV."""
    return csv_text(
        table.headings,
        ([cell.removeprefix("–").replace("−", "-") for cell in row] for row in table.rows),
    )


def table_markdown(table: ResultTable) -> str:
    """Return a table as Markdown, with its title above and its notes below."""
    lines = [f"## {table.title}", ""] if table.title else []
    lines.append(f"| {' | '.join(table.headings)} |")
    lines.append("|" + "---|" * len(table.headings))
    lines += [f"| {' | '.join(row)} |" for row in table.rows]
    if table.notes:
        lines += ["", *(f"- {note}" for note in table.notes)]
    return "\n".join(lines)


def format_number(value: float, unit: str) -> str:
    """Write a number with as many digits as make sense to a reader."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    decimals = 1 if unit in ("%", "ms", "frames") else 2
    if abs(value) >= 100:
        decimals = min(decimals, 1)
    return f"{value:.{decimals}f}".replace("-", "−")


def median_and_range(spread: Spread, unit: str) -> str:
    """Write the median of several runs, and where they differ their range."""
    median, low, high = (
        format_number(value, unit) for value in (spread.median, spread.minimum, spread.maximum)
    )
    return median if low == high else f"{median} ({low} – {high})"
