"""The experiments of Wirth's thesis, section 5.2, on the simulated sequences."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.cable.measure.scan_filters import REACH
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.campaigns.settings import CampaignSettings
from cable_tracker.evaluation.evaluation_sequences import (
    EvaluationSequence,
    ScenarioSequence,
)
from cable_tracker.evaluation.experiments.experiment import (
    CampaignExperiment,
    ExperimentResult,
    FigureFile,
)
from cable_tracker.evaluation.figures import as_png, curves_figure, trace_figure
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.evaluation.result_table import ResultTable, format_number
from cable_tracker.evaluation.run_metrics import (
    METRICS_BY_NAME,
    START_FRAMES,
    StartOutcome,
    StartStatistics,
    start_statistics,
)
from cable_tracker.evaluation.runs import (
    Campaign,
    RunResult,
    Start,
    chosen,
    evaluate_methods,
    methods_of,
    metric_spread,
    sequences_of,
)
from cable_tracker.evaluation.sample_statistics import mean, median, percentage, percentages
from cable_tracker.evaluation.trace import Trace

THESIS_METHODS = ("default", "thesis")
RESTART_FRAMES = 100
"""Frames from one random start to the next (section 5.2.4)."""

SPEED_FRAMES = 100
SPEED_PARTICLES = (100, 200, 300, 500, 1000, 2000)
SPEED_TAPS = (5, 7, 11, 15)
SPEED_HEADINGS = (
    "particles", "filter [px]", "time per frame [ms]", "95th percentile [ms]", "frames lost [%]",
    "RMSE of d [px]",
)  # fmt: skip

CLEAR_VISIBILITY = 0.6
"""A start is clear if on average so large a share of the borders can be seen."""

Advance = Callable[[int], None]


@dataclass(frozen=True, slots=True)
class SequenceExperiment(CampaignExperiment):
    """Section 5.2.3: follow the sequences from their true beginning.

    Attributes
    ----------
    seeds : tuple of int
        Each makes another dive of the same kind.
    sequences : tuple of EvaluationSequence
        Sequences to run on.
    methods : tuple of str
        Keys of `METHODS`.
    """

    seeds: tuple[int, ...]
    sequences: tuple[EvaluationSequence, ...]
    methods: tuple[str, ...] = THESIS_METHODS

    def campaign(self) -> Campaign:
        """Return what is run."""
        return Campaign(self.methods, self.sequences, self.seeds, Start.TRUTH)

    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into tables and figures."""
        names = (
            "useful", "wrong_claims", "longest_loss", "rmse_d", "rmse_alpha", "rmse_w", "rmse_beta",
            "silence", "ms",
        )  # fmt: skip
        titles = (METRICS_BY_NAME[name].title for name in names)
        rows = []
        for sequence in sequences_of(results):
            for method in self.methods:
                runs = chosen(results, sequence=sequence, method=method)
                cells = (_mean_cell(name, runs) for name in names)
                rows.append((sequence, method, str(len(runs)), *cells))
        return ExperimentResult(
            "Sequences followed from their true beginning (thesis, section 5.2.3); means over runs",
            (ResultTable(("sequence", "method", "runs", *titles), tuple(rows)),),
            tuple(_sequence_picture(chosen(results, sequence=s)) for s in sequences_of(results)),
        )


def _sequence_picture(results: Sequence[RunResult]) -> FigureFile:
    first = [chosen(results, method=method)[0] for method in methods_of(results)]
    figure = trace_figure([(f"{run.sequence}, {run.method}", run.trace) for run in first])
    return FigureFile(f"sequence_{results[0].sequence}.png", as_png(figure))


@dataclass(frozen=True, slots=True)
class ReinitialisationExperiment(CampaignExperiment):
    """Section 5.2.4: forget everything every 100 frames, and find the cable again.

    Attributes
    ----------
    seeds, sequences, methods
        See `SequenceExperiment`.
    """

    seeds: tuple[int, ...]
    sequences: tuple[EvaluationSequence, ...]
    methods: tuple[str, ...] = THESIS_METHODS

    def campaign(self) -> Campaign:
        """Return what is run."""
        return Campaign(
            self.methods,
            self.sequences,
            self.seeds,
            Start.RANDOM,
            restart_every=RESTART_FRAMES,
        )

    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into tables and figures."""
        curves = {
            method: _held_after_start(_starts(chosen(results, method=method)))
            for method in self.methods
        }
        figure = curves_figure(
            curves, x_label="frames since a random start", y_label="starts on the cable [%]"
        )
        return ExperimentResult(
            f"Random start every {RESTART_FRAMES} frames (thesis, section 5.2.4)",
            (
                self._table(results, lambda start: True, "All starts", "table.csv"),
                self._table(
                    results,
                    lambda start: start.visibility >= CLEAR_VISIBILITY,
                    f"Clear starts: on average, {100 * CLEAR_VISIBILITY:.0f} % of the borders"
                    f" can be seen over the first {START_FRAMES} frames that show a cable",
                    "clear_starts.csv",
                ),
            ),
            (FigureFile("reinitialisation.png", as_png(figure)),),
        )

    def _table(
        self,
        results: Sequence[RunResult],
        is_counted: Callable[[StartStatistics], bool],
        title: str,
        file_name: str,
    ) -> ResultTable:
        """Return the table of the starts that are counted."""
        names = (*((s, s) for s in sequences_of(results)), ("all", None))
        rows = []
        for name, sequence in names:
            for method in self.methods:
                parts = _starts(chosen(results, sequence=sequence, method=method))
                counted = [part for part in parts if is_counted(start_statistics(part))]
                rows.append(_start_row(name, method, counted))
        headings = (
            "sequence", "method", "starts", f"claimed rightly within {START_FRAMES} frames [%]",
            "claimed wrongly only [%]", "nothing claimed [%]",
            "median frames until claimed rightly", f"lost after {START_FRAMES} frames [%]",
        )  # fmt: skip
        return ResultTable(headings, tuple(rows), title, file_name)


def _starts(results: Sequence[RunResult]) -> list[Trace]:
    """Cut runs into the parts between starts, without those too short to tell."""
    parts = (
        result.trace.part(begin, begin + RESTART_FRAMES)
        for result in results
        for begin in range(0, len(result.trace), RESTART_FRAMES)
    )
    return [part for part in parts if part.visible.sum() >= START_FRAMES]


def _start_row(sequence: str, method: str, parts: Sequence[Trace]) -> tuple[str, ...]:
    starts = [start_statistics(part) for part in parts]
    shares = (
        100.0 * mean([start.outcome is outcome for start in starts])
        for outcome in (StartOutcome.RIGHT, StartOutcome.WRONG, StartOutcome.NONE)
    )
    known = [s.frames_to_right for s in starts if not math.isnan(s.frames_to_right)]
    later = [part.part(START_FRAMES, len(part)) for part in parts if len(part) > START_FRAMES]
    lost, visible = (sum(int(m.sum()) for m in masks) for masks in (
        [part.lost for part in later], [part.visible for part in later]
    ))  # fmt: skip
    numbers = (
        *(format_number(share, "%") for share in shares),
        format_number(median(known), "frames"),
        format_number(percentage(lost, visible), "%"),
    )
    return sequence, method, str(len(starts)), *numbers


def _held_after_start(parts: Sequence[Trace]) -> tuple[list[float], list[float]]:
    """Return frames since the start, and the share of starts on the cable then [%]."""
    held, visible = np.zeros(RESTART_FRAMES), np.zeros(RESTART_FRAMES)
    for part in parts:
        held[: len(part)] += part.useful
        visible[: len(part)] += part.visible
    return list(range(1, RESTART_FRAMES + 1)), percentages(held, visible).tolist()


@dataclass(frozen=True, slots=True)
class _SpeedSetting:
    particles: int
    taps: int

    @property
    def name(self) -> str:
        return f"{self.particles}/{self.taps}"

    def filter(self) -> ConfiguredFilter:
        # The filter ends at so many sigma, so that its sigma says how long it is.
        sigma = (self.taps - 1) / 2 / REACH
        values = {"particle_count": self.particles, "filter_sigma": sigma}
        return ConfiguredFilter(self.name, preset("thesis").replaced(values))


def speed_sequence(limit: int | None = None) -> ScenarioSequence:
    """Return the sequence to measure speed on; `limit`: number of frames used, None: all."""
    return ScenarioSequence("S3", min(SPEED_FRAMES, limit or SPEED_FRAMES))


@dataclass(frozen=True, slots=True)
class SpeedExperiment(CampaignExperiment):
    """Section 5.2.5, Table 5.3: time against particles and filter size, with the thesis' preset.

    Attributes
    ----------
    seeds : tuple of int
        Each makes another dive of the same kind.
    sequence : EvaluationSequence
        Sequence to run on.
    particles, taps : tuple of int
        Numbers of particles and of filter taps; all combinations are run.
    """

    seeds: tuple[int, ...]
    sequence: EvaluationSequence
    particles: tuple[int, ...] = SPEED_PARTICLES
    taps: tuple[int, ...] = SPEED_TAPS

    def campaign(self) -> Campaign:
        """Return what is run."""
        filters = tuple(setting.filter() for setting in self._settings())
        return Campaign((), (self.sequence,), self.seeds, Start.TRUTH, filters=filters)

    def run(self, settings: CampaignSettings, advance: Advance) -> ExperimentResult:
        """Run it in one process, whatever the settings: others would disturb the times."""
        del settings
        return self.result_of(evaluate_methods(self.campaign(), advance=advance))

    def _settings(self) -> list[_SpeedSetting]:
        return [_SpeedSetting(n, taps) for taps in self.taps for n in self.particles]

    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into tables and figures."""
        by_setting = {each: chosen(results, method=each.name) for each in self._settings()}
        rows = tuple(_speed_row(setting, runs) for setting, runs in by_setting.items())
        times = {each: metric_spread("ms", runs).mean for each, runs in by_setting.items()}
        curves = {
            f"{taps} px": (
                [float(n) for n in self.particles],
                [times[_SpeedSetting(n, taps)] for n in self.particles],
            )
            for taps in self.taps
        }
        figure = curves_figure(
            curves, x_label="particles", y_label="time per frame [ms]", markers=True
        )
        return ExperimentResult(
            "Time per frame against particles and filter size (thesis, section 5.2.5, Table 5.3)",
            (ResultTable(SPEED_HEADINGS, rows),),
            (FigureFile("speed.png", as_png(figure)),),
        )


def _mean_cell(metric: str, results: Sequence[RunResult]) -> str:
    return format_number(metric_spread(metric, results).mean, METRICS_BY_NAME[metric].unit)


def _speed_row(setting: _SpeedSetting, results: Sequence[RunResult]) -> tuple[str, ...]:
    numbers = (_mean_cell(metric, results) for metric in ("ms", "ms_p95", "lost", "rmse_d"))
    return str(setting.particles), str(setting.taps), *numbers
