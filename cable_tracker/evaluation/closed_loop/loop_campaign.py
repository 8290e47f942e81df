"""Many closed loops side by side: seeds and methods, and their outcomes in one table."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from cable_tracker.evaluation.closed_loop.loop_table import LoopSummary
from cable_tracker.sequences.tables.csv_tables import format_cell, write_csv

RUNS, METHODS_TABLE = "runs.csv", "methods.csv"


@dataclass(frozen=True, slots=True)
class LoopOutcome:
    """Outcome of one run.

    Attributes
    ----------
    method : str
        Name of the method that tracked.
    seed : int
        Seed of the run.
    summary : LoopSummary or None
        Summary of the run; None if it did not come to an end.
    failure : str
        Reason for its failure, in one line; empty otherwise.
    """

    method: str
    seed: int
    summary: LoopSummary | None
    failure: str = ""


MEASURES: dict[str, tuple[Callable[..., np.floating], str]] = {
    "way": (np.median, "way"),
    "rms": (np.median, "rms"),
    "worst_rms": (np.max, "rms"),
    "most": (np.max, "most"),
    "rms_in_sight": (np.median, "rms_in_sight"),
    "rms_offset": (np.median, "rms_offset"),
    "rms_heading": (np.median, "rms_heading"),
    "measured": (np.mean, "measured"),
    "wrong": (np.mean, "wrong"),
    "losses": (np.mean, "losses"),
    "longest_loss": (np.max, "longest_loss"),
}
"""Columns of a method's totals that are taken over its runs: how, and which field of
`LoopSummary`."""


def totals_by_method(outcomes: Sequence[LoopOutcome]) -> list[dict[str, Any]]:
    """Sum the runs of each method up, in the order in which the methods appear first.

    Returns
    -------
    list of dict
        Columns of the table of methods, in order: the name; how many runs there are, have failed,
        did not lose the cable for good, found it again, are within the goal; `MEASURES` over those
        that came to an end, NaN without any.
    """
    methods = dict.fromkeys(outcome.method for outcome in outcomes)
    return [_totals(name, [each for each in outcomes if each.method == name]) for name in methods]


def _totals(method: str, outcomes: Sequence[LoopOutcome]) -> dict[str, Any]:
    ended = [outcome.summary for outcome in outcomes if outcome.summary is not None]
    return {
        "method": method,
        "runs": len(outcomes),
        "failed": len(outcomes) - len(ended),
        "kept": sum(not summary.lost_for_good for summary in ended),
        "found_again": sum(summary.found_again for summary in ended),
        "within_goal": sum(summary.is_within_goal for summary in ended),
        **{name: _over(ended, *measure) for name, measure in MEASURES.items()},
    }


def _over(ended: Sequence[LoopSummary], measure: Callable[..., np.floating], name: str) -> float:
    values = np.array([getattr(summary, name) for summary in ended], dtype=np.float64)
    values = values[np.isfinite(values)]
    return float(measure(values)) if values.size else math.nan


def write_runs(path: Path, outcomes: Sequence[LoopOutcome]) -> None:
    """Write one line for each run as CSV; of a run that failed, the reason alone."""
    names = [field.name for field in fields(LoopSummary) if field.name != "seed"]
    rows = []
    for outcome in outcomes:
        cells = [
            "" if outcome.summary is None else format_cell(getattr(outcome.summary, name))
            for name in names
        ]
        rows.append([outcome.method, outcome.seed, *cells, outcome.failure])
    write_csv(path, ["method", "seed", *names, "failure"], rows)


def write_methods(path: Path, totals: Sequence[dict[str, Any]]) -> None:
    """Write one line for each method as CSV."""
    rows = (map(format_cell, each.values()) for each in totals)
    write_csv(path, totals[0], rows)
