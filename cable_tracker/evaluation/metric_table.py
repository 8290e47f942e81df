"""The one table of numbers about a run: what the reports show and the CSV files hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import POSE_COMPONENTS
from cable_tracker.evaluation.metrics.errors import ErrorStatistics
from cable_tracker.evaluation.metrics.initialisation import StartOutcome
from cable_tracker.evaluation.metrics.run_metrics import RunMetrics
from cable_tracker.evaluation.runs import RunResult
from cable_tracker.evaluation.sample_statistics import Spread, spread_of


@dataclass(frozen=True, slots=True)
class MetricSpec:
    """One number about a run.

    Attributes
    ----------
    name : str
        Column in tables for machines.
    label : str
        For people.
    unit : str
        Unit of the value as `read` returns it; empty for pure numbers.
    read : callable
        Takes the number out of the metrics; NaN where it is not defined.
    """

    name: str
    label: str
    unit: str
    read: Callable[[RunMetrics], float]

    @property
    def heading(self) -> str:
        """Name and unit, for a table's column."""
        return self._with_unit(self.name)

    @property
    def title(self) -> str:
        """Label and unit, for a table's column or a table of its own."""
        return self._with_unit(self.label)

    def _with_unit(self, text: str) -> str:
        return f"{text} [{self.unit}]" if self.unit else text


def _error_specs(
    prefix: str, words: str, statistics: Callable[[RunMetrics], ErrorStatistics]
) -> Iterable[MetricSpec]:
    measures: tuple[tuple[str, str, Callable[[ErrorStatistics], FloatArray]], ...] = (
        ("bias", "bias", lambda s: s.bias),
        ("rmse", "RMSE", lambda s: s.rmse),
        ("median", "median", lambda s: s.median),
        ("p95", "95th percentile", lambda s: s.percentile_95),
    )
    for name, label, values in measures:
        for column, (axis, symbol, unit, factor) in enumerate(POSE_COMPONENTS):
            yield MetricSpec(
                f"{prefix}{name}_{axis}",
                f"{label} of {symbol}{words}",
                unit,
                lambda m, v=values, c=column, f=factor: float(v(statistics(m))[c]) * f,  # type: ignore[misc]
            )


def _inside_specs() -> Iterable[MetricSpec]:
    for column, (axis, symbol, _, _) in enumerate(POSE_COMPONENTS):
        yield MetricSpec(
            f"inside_2_sigma_{axis}",
            f"truth of {symbol} inside 2σ",
            "%",
            lambda m, c=column: 100.0 * float(m.consistency.inside[c]),  # type: ignore[misc]
        )


def _start_flag(outcome: StartOutcome) -> Callable[[RunMetrics], float]:
    def read(metrics: RunMetrics) -> float:
        if metrics.start is None or metrics.start.outcome is None:
            return math.nan
        return 100.0 * (metrics.start.outcome is outcome)

    return read


def _frames_to_right(metrics: RunMetrics) -> float:
    return metrics.start.frames_to_right if metrics.start is not None else math.nan


METRIC_TABLE: tuple[MetricSpec, ...] = (
    MetricSpec("frames", "frames", "", lambda m: float(m.frame_count)),
    MetricSpec("visible", "frames with a visible cable", "", lambda m: float(m.visible_count)),
    MetricSpec("useful", "useful frames", "%", lambda m: 100.0 * m.claims.useful),
    MetricSpec("lost", "frames lost", "%", lambda m: 100.0 * m.loss.share),
    MetricSpec("longest_loss_frames", "longest loss", "frames", lambda m: m.loss.longest_frames),
    MetricSpec("longest_loss", "longest loss", "s", lambda m: m.loss.longest_seconds),
    MetricSpec("recovery", "time to recover", "s", lambda m: m.loss.recovery_seconds),
    MetricSpec("unrecovered", "losses never recovered", "", lambda m: m.loss.unrecovered),
    MetricSpec("false_tracking", "false tracking", "%", lambda m: 100.0 * m.claims.false_tracking),
    MetricSpec("silence", "silence", "%", lambda m: 100.0 * m.claims.silence),
    MetricSpec(
        "wrong_claims", "wrong claims, of all claims", "%", lambda m: 100.0 * m.claims.wrong_claims
    ),
    MetricSpec("start_right", "right start", "%", _start_flag(StartOutcome.RIGHT)),
    MetricSpec("start_wrong", "wrong lock", "%", _start_flag(StartOutcome.WRONG)),
    MetricSpec("frames_to_right", "frames until the cable is claimed", "", _frames_to_right),
    MetricSpec("returns", "returns of the cable", "", lambda m: m.returns.count),
    MetricSpec("found_again", "found again", "%", lambda m: 100.0 * m.returns.found),
    MetricSpec("time_to_find", "time to find it again", "s", lambda m: m.returns.seconds),
    *_error_specs("", "", lambda m: m.errors),
    *_error_specs("held_", " while held", lambda m: m.held_errors),
    MetricSpec("nees_mean", "mean NEES", "", lambda m: m.consistency.nees_mean),
    MetricSpec("nees_median", "median NEES", "", lambda m: m.consistency.nees_median),
    *_inside_specs(),
    MetricSpec(
        "inside_region",
        "truth inside the 95 % region",
        "%",
        lambda m: 100.0 * m.consistency.inside_region,
    ),
    MetricSpec("ms", "processor time per frame", "ms", lambda m: m.ms_median),
    MetricSpec(
        "ms_p95", "95th percentile of the processor time per frame", "ms", lambda m: m.ms_95
    ),
)
"""Metrics of a run, in the order of the tables."""

METRICS_BY_NAME: Mapping[str, MetricSpec] = {spec.name: spec for spec in METRIC_TABLE}


def metric_spread(name: str, results: Iterable[RunResult]) -> Spread:
    """Summarise one number over several runs; `name` is a key of `METRICS_BY_NAME`."""
    read = METRICS_BY_NAME[name].read
    return spread_of(read(result.metrics) for result in results)
