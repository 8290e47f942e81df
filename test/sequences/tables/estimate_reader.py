"""Read tables of estimates back, for tests: the package only writes them."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path

from cable_tracker.cable.model.state import POSE_SYMBOLS, STATE_SYMBOLS, CableState
from cable_tracker.sequences.tables.estimates import EstimateRow, RowMetres
from cable_tracker.stamps import NANOSECONDS

SIGMAS = tuple(f"sigma_{symbol}" for symbol in POSE_SYMBOLS)
METRES = ("offset", "heading", "sigma_offset", "sigma_heading")


def read_estimates(path: Path) -> list[EstimateRow]:
    """Return the rows of a table that `write_estimates` has written."""
    with path.open(newline="", encoding="utf-8") as file:
        return [_row(cells) for cells in csv.DictReader(file)]


def _row(cells: Mapping[str, str]) -> EstimateRow:
    state, sigma, metres = (_all(cells, names) for names in (STATE_SYMBOLS, SIGMAS, METRES))
    return EstimateRow(
        frame=int(cells["frame"]),
        stamp=int(Decimal(cells["stamp"]) * NANOSECONDS),
        status=cells["status"],
        state=CableState(*state) if state else None,
        sigma=sigma,
        n_eff=_number(cells["n_eff"]),
        presence=_number(cells["presence"]),
        evidence=_number(cells["evidence"]),
        hypotheses=int(cells["hypotheses"]) if cells["hypotheses"] else None,
        ms=_number(cells["ms"]),
        metres=RowMetres(*metres) if metres else None,
        no_metres=cells["no_metres"],
        event=cells["event"],
    )


def _number(cell: str) -> float | None:
    return float(cell) if cell else None


def _all(cells: Mapping[str, str], names: tuple[str, ...]) -> tuple[float, ...] | None:
    """Return the numbers of some columns; None where all are empty."""
    if not any(cells[name] for name in names):
        return None
    return tuple(float(cells[name]) for name in names)
