"""Worth and cost of each part of the preset `default`: trackers that differ from it in one part."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.evaluation_sequences import (
    THESIS_SEQUENCES,
    EvaluationSequence,
    reported_worlds,
    simulated_sequences,
)
from cable_tracker.evaluation.experiments.experiment import CampaignExperiment, ExperimentResult
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.evaluation.result_table import ResultTable, format_number
from cable_tracker.evaluation.run_metrics import METRICS_BY_NAME
from cable_tracker.evaluation.runs import (
    Campaign,
    RunResult,
    Start,
    chosen,
    metric_spread,
    sequences_of,
)
from cable_tracker.evaluation.sample_statistics import spread_of
from cable_tracker.tracking.parameter_table import ParameterValue, check_name

DEFAULT = "default"

MEAN_METRICS = (
    "wrong_claims", "silence", "false_tracking", "median_d", "median_alpha", "nees_median", "ms",
    "inside_2_sigma_d", "inside_2_sigma_alpha", "inside_2_sigma_w", "inside_2_sigma_beta",
)  # fmt: skip
"""Given as means over the sequences, beside the frames lost."""

BRIEF_COLUMNS = 12
"""Row, losses and their changes, and the first metrics fit on a terminal."""

TABLE_FILE = "taken_away.csv"

EXPLANATION = (
    "Means over the sequences, of means over the runs; ± is one standard error, from the spread of"
    " the runs within each sequence. *Lost more than* another row compares run by run, on the same"
    " dives. Medians of d and α are those of the absolute error, over all frames with a visible"
    " cable."
)

Losses: TypeAlias = Mapping[tuple[str, int], float]
"""Share of the frames lost by sequence and seed [%]."""


VARIANCES = (
    "distance_variance", "angle_variance", "width_variance", "skew_variance",
    "distance_rate_variance", "angle_rate_variance", "width_rate_variance", "skew_rate_variance",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class AblationRow:
    """A tracker of the ablation.

    Attributes
    ----------
    name : str
        Name in tables and on the command line.
    description : str
        Difference from `default`, in a few words.
    changes : mapping of str to ParameterValue
        Changed values by parameter.
    """

    name: str
    description: str
    changes: Mapping[str, ParameterValue]

    def parameters(self) -> TrackerParameters:
        """Return all parameters.

        Raises
        ------
        ParameterError
            The changes are not possible.
        """
        return preset(DEFAULT).replaced(self.changes)


ABLATION_ROWS = (
    AblationRow(DEFAULT, "the preset", {}),
    AblationRow("no_detector", "no detector proposes cables", {"detector": "none"}),
    AblationRow("no_network", "no network says where a cable may be", {"looks": "borders"}),
    AblationRow(
        "map_where_faint",
        "the network looks at a known cable only where a border of it is faint",
        {"map_interval": 3600.0},
    ),
    AblationRow("borders_width", "the width is that of the borders", {"map_width_share": 0.0}),
    AblationRow(
        "no_refinement", "no particles drawn anew in the same frame", {"refinement_rounds": 0}
    ),
    AblationRow("gaussian", "Gaussian diffusion", {"diffusion_degrees_of_freedom": 0.0}),
    AblationRow(
        "constant_shape",
        "no rates of w and β",
        {"width_rate_variance": 0.0, "skew_rate_variance": 0.0},
    ),
    AblationRow("uneven_light", "uneven light left in", {"light_correction": 0.0}),
    AblationRow("burned_in", "lines of a survey display left in", {"burned_in_time": 0.0}),
    AblationRow("free_outside", "points outside the image cost nothing", {"missing_cost": 0.0}),
    AblationRow("no_bands", "no cable changes between bright and dark", {"reversal_cost": 1e3}),
    AblationRow("no_covered_ends", "no end of a cable is covered", {"covered_cost": 1e3}),
    AblationRow("hardly_tempered", "points of a border all but independent", {"tempering": 0.3}),
    AblationRow("any_width", "no usual width", {"width_spread": 100.0}),
    AblationRow(
        "evidence_in_full",
        "evidence counts in full every frame",
        {"evidence_repeated": 1.0, "evidence_limit": 1e6, "evidence_limit_known": 1e6},
    ),
    AblationRow("never_known", "a known cable counts as any other", {"evidence_limit_known": 18.0}),
    AblationRow(
        "fixtures_kept",
        "what is fixed to the vehicle is followed, too",
        {"fixture_travel": 0.0},
    ),
    AblationRow("no_polarity", "bright or dark not remembered", {"polarity_memory": 0.0}),
    AblationRow("undamped", "undamped rates, as in the thesis", {"rate_damping": 1.0}),
    AblationRow(
        "thesis_variances",
        "variances of the diffusion as in the thesis",
        {name: preset("thesis").as_mapping()[name] for name in VARIANCES},
    ),
    AblationRow("particles_2000", "2000 particles", {"particle_count": 2000}),
    AblationRow("particles_200", "200 particles", {"particle_count": 200}),
)

ROW_NAMES = tuple(row.name for row in ABLATION_ROWS)
"""Names of all rows, in order."""


def check_row_names(names: Sequence[str]) -> None:
    """Check that these rows exist, at least one.

    Raises
    ------
    ParameterError
        There is no such row, or none is named.
    """
    if not names:
        raise ParameterError(f"row: give at least one of {' | '.join(ROW_NAMES)}")
    for name in names:
        check_name("row", name, ROW_NAMES)


@dataclass(frozen=True, slots=True)
class AblationExperiment(CampaignExperiment):
    """Follow sequences with one part changed.

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
        Notes on the sequences, below the table.
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
        filters = tuple(ConfiguredFilter(row.name, row.parameters()) for row in self._rows())
        return Campaign((), self.sequences, self.seeds, self.start, filters=filters)

    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into a table."""
        rows = self._rows()
        table = ResultTable(
            headings=_headings(sequences_of(results)),
            rows=tuple(_cells(row, results) for row in rows),
            title="Taken away: `default` with one part changed back",
            file_name=TABLE_FILE,
            notes=(EXPLANATION, *(_note(row) for row in rows), *self.notes),
            brief=BRIEF_COLUMNS,
        )
        return ExperimentResult(
            "What the parts of the preset default are worth, and what they cost", (table,)
        )

    def _rows(self) -> list[AblationRow]:
        return [row for row in ABLATION_ROWS if row.name in self.rows]


def cold_ablation(seeds: tuple[int, ...], limit: int | None = None) -> AblationExperiment:
    """Return the ablation on the worlds to report on, from cold starts, with one part changed.

    There the parts earn their keep that find a cable; a start from the truth does not ask for them.
    `limit`: number of frames used of each world; None: all.
    """
    worlds, notes = reported_worlds(limit)
    return AblationExperiment(seeds, ROW_NAMES, worlds, Start.RANDOM, notes)


def _headings(sequences: Sequence[str]) -> tuple[str, ...]:
    return (
        "row", "frames lost [%]", "± [%]", "lost more than", "by [%]", "± of that [%]",
        *(METRICS_BY_NAME[name].title for name in MEAN_METRICS),
        *(f"{name}: frames lost [%]" for name in sequences),
    )  # fmt: skip


def _cells(row: AblationRow, results: Sequence[RunResult]) -> tuple[str, ...]:
    runs = chosen(results, method=row.name)
    lost = _losses(runs)
    compared = {} if row.name == DEFAULT else _losses(chosen(results, method=DEFAULT))
    more = {key: value - compared[key] for key, value in lost.items() if key in compared}
    sequences = sequences_of(results)
    return (
        row.name,
        *(format_number(number, "%") for number in mean_and_error(lost, sequences)),
        DEFAULT if more else "–",
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


def _note(row: AblationRow) -> str:
    """Describe a row, with the values that differ from `default`."""
    usual = preset(DEFAULT).as_mapping()
    changes = [
        f"`{name}` = {_value(value)}"
        for name, value in row.parameters().as_mapping().items()
        if value != usual[name]
    ]
    return f"`{row.name}`: {row.description}" + (f" ({', '.join(changes)})" if changes else "")


def _value(value: ParameterValue) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
