"""Worth and cost of each part of the preset `default`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cable_tracker.evaluation.campaign import Campaign
from cable_tracker.evaluation.evaluation_sequences import (
    THESIS_SEQUENCES,
    EvaluationSequence,
    available_worlds,
    left_out_notes,
    simulated_sequences,
)
from cable_tracker.evaluation.experiments.ablation_rows import (
    ABLATION_TABLES,
    ROW_NAMES,
    TAKEN_AWAY,
    AblationRow,
    AblationTable,
    check_row_names,
)
from cable_tracker.evaluation.experiments.campaign_experiment import CampaignExperiment
from cable_tracker.evaluation.experiments.experiment_result import ExperimentResult, ResultTable
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.evaluation.metric_table import METRICS_BY_NAME, metric_spread
from cable_tracker.evaluation.report import format_number
from cable_tracker.evaluation.runs import RunResult, Start
from cable_tracker.evaluation.sample_statistics import spread_of
from cable_tracker.evaluation.tables import chosen, sequences_of
from cable_tracker.simulation.worlds.catalogue import worlds_of
from cable_tracker.simulation.worlds.world import Split
from cable_tracker.tracking.parameter_table import ParameterValue

MEAN_METRICS = (
    "wrong_claims", "silence", "false_tracking", "median_d", "median_alpha", "nees_median", "ms",
    "inside_2_sigma_d", "inside_2_sigma_alpha", "inside_2_sigma_w", "inside_2_sigma_beta",
)  # fmt: skip
"""Given as means over the sequences, beside the frames lost."""

BRIEF_COLUMNS = 12
"""Row, losses and their changes, and the first metrics fit on a terminal."""

EXPLANATION = (
    "Means over the sequences, of means over the runs; ± is one standard error, from the spread of"
    " the runs within each sequence. *Lost more than* another row compares run by run, on the same"
    " dives. Medians of d and α are those of the absolute error, over all frames with a visible"
    " cable."
)

Losses: TypeAlias = Mapping[tuple[str, int], float]
"""Share of the frames lost by sequence and seed [%]."""


@dataclass(frozen=True, slots=True)
class AblationExperiment(CampaignExperiment):
    """Follow sequences with one part changed, or parts added.

    Attributes
    ----------
    seeds : tuple of int
        Each makes another dive of the same kind.
    rows : tuple of str
        Rows to run, keys of `ROW_NAMES`.
    sequences : tuple of EvaluationSequence
        Sequences to run on.
    start : Start
        What the trackers are told at the beginning.
    notes : tuple of str
        What is said of the sequences, below the tables.
    """

    seeds: tuple[int, ...]
    rows: tuple[str, ...] = ROW_NAMES
    sequences: tuple[EvaluationSequence, ...] = simulated_sequences(THESIS_SEQUENCES)
    start: Start = Start.TRUTH
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_row_names(self.rows)

    def campaign(self) -> Campaign:
        """Return what is run."""
        rows = {row.name: row for table in ABLATION_TABLES for row in table.rows}
        filters = tuple(
            ConfiguredFilter(name, rows[name].parameters())
            for name in ROW_NAMES
            if name in self.rows
        )
        return Campaign((), self.sequences, self.seeds, self.start, filters=filters)

    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into tables and figures."""
        tables = (self._table(table, results) for table in ABLATION_TABLES)
        return ExperimentResult(
            "What the parts of the preset default are worth, and what they cost",
            tuple(table for table in tables if table.rows),
        )

    def _table(self, table: AblationTable, results: Sequence[RunResult]) -> ResultTable:
        rows = [row for row in table.rows if row.name in self.rows]
        return ResultTable(
            headings=_headings(sequences_of(results)),
            rows=tuple(_cells(row, results) for row in rows),
            title=table.title,
            file_name=table.file_name,
            notes=(EXPLANATION, *(_note(row, table) for row in rows), *self.notes),
            brief=BRIEF_COLUMNS,
        )


def cold_ablation(seeds: tuple[int, ...], limit: int | None = None) -> AblationExperiment:
    """Return the ablation on the worlds to report on, from cold starts, with one part changed.

    There the parts earn their keep that find a cable; a start from the truth does not ask for them.
    `limit`: number of frames used of each world; None: all.
    """
    rows = tuple(row.name for row in TAKEN_AWAY.rows)
    worlds, left_out = available_worlds(worlds_of(Split.REPORT), limit)
    return AblationExperiment(seeds, rows, worlds, Start.RANDOM, left_out_notes(left_out))


def _headings(sequences: Sequence[str]) -> tuple[str, ...]:
    return (
        "row", "frames lost [%]", "± [%]", "lost more than", "by [%]", "± of that [%]",
        *(METRICS_BY_NAME[name].title for name in MEAN_METRICS),
        *(f"{name}: frames lost [%]" for name in sequences),
    )  # fmt: skip


def _cells(row: AblationRow, results: Sequence[RunResult]) -> tuple[str, ...]:
    runs = chosen(results, method=row.name)
    lost = _losses(runs)
    compared = _losses(chosen(results, method=row.compared_to)) if row.compared_to else {}
    more = {key: value - compared[key] for key, value in lost.items() if key in compared}
    sequences = sequences_of(results)
    return (
        row.name,
        *(format_number(number, "%") for number in mean_and_error(lost, sequences)),
        row.compared_to if more else "–",
        *(format_number(number, "%") for number in mean_and_error(more, sequences)),
        *(_mean_cell(name, runs) for name in MEAN_METRICS),
        *(format_number(_mean(_of(lost, name)), "%") for name in sequences),
    )


def _losses(runs: Iterable[RunResult]) -> Losses:
    return {(run.sequence, run.seed): run.metrics["lost"] for run in runs}


def _of(losses: Losses, sequence: str) -> list[float]:
    return [value for (name, _), value in losses.items() if name == sequence]


def _mean(values: Iterable[float]) -> float:
    return spread_of(values).mean


def mean_and_error(losses: Losses, sequences: Sequence[str]) -> tuple[float, float]:
    """Return the mean over the sequences and its standard error, both in the unit of the losses.

    The sequences are chosen, not drawn: only the runs within each of them make the mean uncertain.
    """
    spreads = [spread_of(_of(losses, name)) for name in sequences]
    errors = np.array([spread.standard_error for spread in spreads if spread.count])
    error = float(np.sqrt((errors**2).sum()) / len(errors)) if len(errors) else math.nan
    return _mean(spread.mean for spread in spreads), error


def _mean_cell(metric: str, runs: Sequence[RunResult]) -> str:
    means = (metric_spread(metric, chosen(runs, sequence=name)).mean for name in sequences_of(runs))
    return format_number(_mean(means), METRICS_BY_NAME[metric].unit)


def _note(row: AblationRow, table: AblationTable) -> str:
    """Say what a row is, and which values it has that the row compared with has not."""
    others = {other.name: other for other in table.rows}
    if not row.compared_to:
        return f"`{row.name}`: {row.description}"
    before = others[row.compared_to].parameters().as_mapping()
    changes = [
        f"`{name}` = {_value(value)}"
        for name, value in row.parameters().as_mapping().items()
        if value != before[name]
    ]
    return f"`{row.name}`: {row.description} ({', '.join(changes) or 'no other value'})"


def _value(value: ParameterValue) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
