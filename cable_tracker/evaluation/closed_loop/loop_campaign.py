"""Many closed loops side by side: seeds and methods, and what came of them in one table."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from cable_tracker.evaluation.closed_loop.loop_table import LoopSummary
from cable_tracker.sequences.tables.csv_tables import format_cell, write_csv, write_records

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


@dataclass(frozen=True, slots=True)
class MethodTotals:
    """Summary of all runs of a method. Lengths in metres, times in seconds.

    Medians and maxima are taken over the runs that came to an end; NaN without any.

    Attributes
    ----------
    method : str
        Name of the method that tracked.
    runs, failed : int
        Number of runs, and of those that did not come to an end.
    kept : int
        Number of runs in which the cable was not lost for good.
    found_again : int
        Number of runs in which it was found again after the buried stretch.
    within_goal : int
        In how many the lateral error was as small as is aimed at, and the cable not lost.
    way : float
        Way of the vehicle along the cable: median.
    rms, worst_rms, most : float
        Lateral error: the median of the runs' RMS, the largest RMS, and the largest error.
    rms_in_sight : float
        Median of the RMS with the cable in sight.
    rms_offset, rms_heading : float
        Errors of `cross_track` where it was right: medians of the runs' RMS [m, deg].
    measured, wrong : float
        Shares of the frames with a `cross_track`, and with one that was not the cable's: means.
    losses : float
        Number of stops of the controller: mean.
    longest_loss : float
        Longest loss over all runs.
    """

    method: str
    runs: int
    failed: int
    kept: int
    found_again: int
    within_goal: int
    way: float
    rms: float
    worst_rms: float
    most: float
    rms_in_sight: float
    rms_offset: float
    rms_heading: float
    measured: float
    wrong: float
    losses: float
    longest_loss: float


def totals_by_method(outcomes: Sequence[LoopOutcome]) -> list[MethodTotals]:
    """Sum the runs of each method up, in the order in which the methods appear first."""
    methods = dict.fromkeys(outcome.method for outcome in outcomes)
    return [_totals(name, [each for each in outcomes if each.method == name]) for name in methods]


def _totals(method: str, outcomes: Sequence[LoopOutcome]) -> MethodTotals:
    ended = [outcome.summary for outcome in outcomes if outcome.summary is not None]

    def over(measure: Callable[..., np.floating], name: str) -> float:
        values = np.array([getattr(summary, name) for summary in ended], dtype=np.float64)
        values = values[np.isfinite(values)]
        return float(measure(values)) if values.size else math.nan

    return MethodTotals(
        method=method,
        runs=len(outcomes),
        failed=len(outcomes) - len(ended),
        kept=sum(not summary.lost_for_good for summary in ended),
        found_again=sum(summary.found_again for summary in ended),
        within_goal=sum(summary.is_within_goal for summary in ended),
        way=over(np.median, "way"),
        rms=over(np.median, "rms"),
        worst_rms=over(np.max, "rms"),
        most=over(np.max, "most"),
        rms_in_sight=over(np.median, "rms_in_sight"),
        rms_offset=over(np.median, "rms_offset"),
        rms_heading=over(np.median, "rms_heading"),
        measured=over(np.mean, "measured"),
        wrong=over(np.mean, "wrong"),
        losses=over(np.mean, "losses"),
        longest_loss=over(np.max, "longest_loss"),
    )


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


def write_methods(path: Path, totals: Sequence[MethodTotals]) -> None:
    """Write one line for each method as CSV."""
    write_records(path, MethodTotals, totals)
