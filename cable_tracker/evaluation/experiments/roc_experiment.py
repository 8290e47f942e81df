"""Useful frames against wrongly claimed ones over the thresholds, on the worlds to report on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.evaluation.evaluation_sequences import (
    EvaluationSequence,
    reported_worlds,
)
from cable_tracker.evaluation.experiments.experiment import (
    CampaignExperiment,
    ExperimentResult,
    FigureFile,
)
from cable_tracker.evaluation.figures import as_png, trade_off_figure
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.evaluation.result_table import ResultTable, format_number
from cable_tracker.evaluation.run_metrics import StartOutcome, start_statistics
from cable_tracker.evaluation.runs import Campaign, RunResult, Start, chosen
from cable_tracker.evaluation.sample_statistics import percentage
from cable_tracker.evaluation.trace import Trace

PRESENCES = (0.3, 0.6, 0.8, 0.9, 0.95, 0.98)
"""Values of `presence_to_track`, with the evidence asked for as in `default`."""

EVIDENCES = (-5.0, -1.0, 0.0, 0.2, 1.0, 2.0)
"""Values of `evidence_to_track` and `evidence_to_find`, the presence asked for as in `default`."""

DEFAULT = preset("default")

LOSING = DEFAULT.presence_to_lose / DEFAULT.presence_to_track
"""`presence_to_lose` over `presence_to_track`, as in `default`."""

HYSTERESIS = DEFAULT.evidence_to_track - DEFAULT.evidence_to_lose
"""`evidence_to_track` less `evidence_to_lose`, as in `default`."""

NOTE = (
    "With `presence_to_track`, `presence_to_lose` changes in the same ratio. With"
    " `evidence_to_track`, `evidence_to_find` takes the same value, and `evidence_to_lose` stays"
    f" {HYSTERESIS:g} below: no row of it is the preset, whose `evidence_to_find` is"
    f" {DEFAULT.evidence_to_find:g}."
)

SHARES_NOTE = (
    "Useful, wrongly claimed and silent are shares of the frames with a visible cable, and add up"
    " to 100 %; *wrong claims* of the other tables are a share of the claims."
)

HEADINGS = (
    "setting", "useful [%]", "wrongly claimed [%]", "silence [%]", "claimed without a cable [%]",
    "started rightly [%]", "wrong lock [%]",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Threshold:
    parameter: str
    value: float

    @property
    def name(self) -> str:
        return f"{self.parameter} {self.value:g}"

    def filter(self) -> ConfiguredFilter:
        if self.parameter == "presence_to_track":
            others = {"presence_to_lose": LOSING * self.value}
        else:
            others = {
                "evidence_to_find": self.value,
                "evidence_to_lose": self.value - HYSTERESIS,
            }
        values = {self.parameter: self.value, **others}
        return ConfiguredFilter(self.name, preset("default").replaced(values))


THRESHOLDS = (
    *(_Threshold("presence_to_track", value) for value in PRESENCES),
    *(_Threshold("evidence_to_track", value) for value in EVIDENCES),
)


@dataclass(frozen=True, slots=True)
class RocExperiment(CampaignExperiment):
    """Follow worlds from cold starts with the preset `default` and one threshold changed.

    Attributes
    ----------
    seeds : tuple of int
        Seeds; each makes another dive through each world.
    sequences : tuple of EvaluationSequence
        Sequences to follow.
    notes : tuple of str
        Remarks on the sequences, below the table.
    """

    seeds: tuple[int, ...]
    sequences: tuple[EvaluationSequence, ...]
    notes: tuple[str, ...] = ()

    def campaign(self) -> Campaign:
        """Return what is run."""
        filters = tuple(threshold.filter() for threshold in THRESHOLDS)
        return Campaign((), self.sequences, self.seeds, Start.RANDOM, filters=filters)

    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into tables and figures."""
        curves: dict[str, list[tuple[float, ...]]] = {}
        rows = []
        for threshold in THRESHOLDS:
            numbers = claim_shares(chosen(results, method=threshold.name))
            rows.append((threshold.name, *(format_number(each, "%") for each in numbers)))
            useful, wrongly_claimed, _, without_cable, *_ = numbers
            point = (threshold.value, useful, wrongly_claimed, without_cable)
            curves.setdefault(threshold.parameter, []).append(point)
        figure = trade_off_figure(
            {name: np.array(points) for name, points in curves.items()},
            gain="useful [%]",
            prices=("wrongly claimed [%]", "claimed without a cable [%]"),
        )
        notes = (SHARES_NOTE, NOTE, *self.notes)
        return ExperimentResult(
            "Useful frames against wrongly claimed ones over the thresholds, from cold starts",
            (ResultTable(HEADINGS, tuple(rows), notes=notes),),
            (FigureFile("roc.png", as_png(figure)),),
        )


def reported_roc(seeds: tuple[int, ...], limit: int | None = None) -> RocExperiment:
    """Return the experiment on the worlds to report on; `limit`: frames used of each, None: all."""
    return RocExperiment(seeds, *reported_worlds(limit))


def claim_shares(results: Sequence[RunResult]) -> tuple[float, ...]:
    """Return shares over the frames of all runs together [%].

    Returns
    -------
    tuple of float
        Useful, wrongly claimed and silent of the frames with a visible cable; claimed of those
        without one; right starts and wrong locks of the runs that show one. NaN where there is
        nothing to count.
    """
    traces = [result.trace for result in results]
    visible, hidden = _count(traces, lambda t: t.visible), _count(traces, lambda t: t.hidden)
    outcomes = [outcome for t in traces if (outcome := start_statistics(t).outcome)]
    return (
        percentage(_count(traces, lambda t: t.useful), visible),
        percentage(_count(traces, lambda t: t.visible & t.claimed & ~t.useful), visible),
        percentage(_count(traces, lambda t: t.visible & ~t.claimed), visible),
        percentage(_count(traces, lambda t: t.hidden & t.claimed), hidden),
        percentage(outcomes.count(StartOutcome.RIGHT), len(outcomes)),
        percentage(outcomes.count(StartOutcome.WRONG), len(outcomes)),
    )


def _count(traces: Sequence[Trace], flags: Callable[[Trace], BoolArray]) -> int:
    return sum(int(flags(trace).sum()) for trace in traces)
