"""Tables as comma-separated values, as this package writes them."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable


def csv_text(headings: Iterable[object], rows: Iterable[Iterable[object]]) -> str:
    """Return a table, one line for the headings and one for each row.

    Lines end with a line feed alone. Cells are written by `str`; those that hold commas, quotation
    marks or line feeds are quoted.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(headings)
    writer.writerows(rows)
    return text.getvalue()
