"""The results of many runs as CSV files."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from cable_tracker.evaluation.metric_table import METRIC_TABLE, metric_spread
from cable_tracker.evaluation.runs import RunResult, chosen, methods_of, sequences_of
from cable_tracker.sequences.tables.csv_tables import csv_text
from cable_tracker.sequences.tables.estimates import format_stamp

FRAME_HEADINGS = (
    "sequence", "method", "seed", "frame", "stamp [s]", "status", "visibility", "lost",
    "true_d [px]", "true_alpha [rad]", "true_w [px]", "true_beta [rad]",
    "d [px]", "alpha [rad]", "w [px]", "beta [rad]",
    "sigma_d [px]", "sigma_alpha [rad]", "sigma_w [px]", "sigma_beta [rad]", "ms",
)  # fmt: skip

SUMMARY_HEADINGS = (
    "sequence", "method", "metric", "unit", "runs",
    "mean", "standard_error", "median", "minimum", "maximum",
)  # fmt: skip


def _text(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.6g}"


def runs_csv(results: Iterable[RunResult]) -> str:
    """Return a table with one row for each run and a column for each number about it."""
    headings = ("sequence", "method", "seed", "start", *(spec.heading for spec in METRIC_TABLE))
    return csv_text(headings, (_run_row(result) for result in results))


def _run_row(result: RunResult) -> list[str]:
    numbers = (_text(result.metrics[spec.name]) for spec in METRIC_TABLE)
    return [result.sequence, result.method, str(result.seed), result.start.value, *numbers]


def summary_csv(results: Sequence[RunResult]) -> str:
    """Return a table with one row for each number of each method on each sequence, over seeds."""
    return csv_text(SUMMARY_HEADINGS, _summary_rows(results))


def _summary_rows(results: Sequence[RunResult]) -> Iterable[Sequence[str]]:
    for sequence in sequences_of(results):
        for method in methods_of(results):
            runs = chosen(results, sequence=sequence, method=method)
            for spec in METRIC_TABLE:
                spread = metric_spread(spec.name, runs)
                numbers = (
                    spread.mean,
                    spread.standard_error,
                    spread.median,
                    spread.minimum,
                    spread.maximum,
                )
                yield (
                    sequence, method, spec.name, spec.unit, str(spread.count),
                    *(_text(number) for number in numbers),
                )  # fmt: skip


def frames_csv(results: Iterable[RunResult]) -> str:
    """Return a table with one row for each frame of each run."""
    rows = (row for result in results for row in _frame_rows(result))
    return csv_text(FRAME_HEADINGS, rows)


def _frame_rows(result: RunResult) -> Iterable[Sequence[str]]:
    trace = result.trace
    numbers = np.hstack((trace.truths, trace.estimates, trace.sigmas, trace.ms[:, None]))
    lost, visible = trace.lost, trace.visible
    for place, values in enumerate(numbers):
        yield (
            result.sequence,
            result.method,
            str(result.seed),
            str(trace.frames[place]),
            format_stamp(int(trace.stamps[place])),
            trace.statuses[place].value,
            _text(trace.visibility[place]),
            str(int(lost[place])) if visible[place] else "",
            *(_text(value) for value in values),
        )


CSV_FILES: tuple[tuple[str, Callable[[Sequence[RunResult]], str]], ...] = (
    ("runs.csv", runs_csv),
    ("summary.csv", summary_csv),
    ("frames.csv", frames_csv),
)
"""Names of the tables in the folder of an evaluation, and what makes them."""
