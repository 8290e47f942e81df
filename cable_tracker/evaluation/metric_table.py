"""The table of all metrics of a run: names, labels and units for reports and CSV files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from cable_tracker.cable.model.state import POSE_COMPONENTS
from cable_tracker.evaluation.runs import RunResult
from cable_tracker.evaluation.sample_statistics import Spread, spread_of


@dataclass(frozen=True, slots=True)
class MetricSpec:
    """One number about a run, of which `run_metrics` makes the value.

    Attributes
    ----------
    name : str
        Column in tables for machines.
    label : str
        For people.
    unit : str
        Unit of the value; empty for pure numbers.
    """

    name: str
    label: str
    unit: str = ""

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


def _error_specs(prefix: str, words: str) -> Iterable[MetricSpec]:
    measures = {"bias": "bias", "rmse": "RMSE", "median": "median", "p95": "95th percentile"}
    for name, label in measures.items():
        for axis, symbol, unit, _ in POSE_COMPONENTS:
            yield MetricSpec(f"{prefix}{name}_{axis}", f"{label} of {symbol}{words}", unit)


METRIC_TABLE: tuple[MetricSpec, ...] = (
    MetricSpec("frames", "frames"),
    MetricSpec("visible", "frames with a visible cable"),
    MetricSpec("useful", "useful frames", "%"),
    MetricSpec("lost", "frames lost", "%"),
    MetricSpec("longest_loss_frames", "longest loss", "frames"),
    MetricSpec("longest_loss", "longest loss", "s"),
    MetricSpec("recovery", "time to recover", "s"),
    MetricSpec("unrecovered", "losses never recovered"),
    MetricSpec("false_tracking", "false tracking", "%"),
    MetricSpec("silence", "silence", "%"),
    MetricSpec("wrong_claims", "wrong claims, of all claims", "%"),
    MetricSpec("start_right", "right start", "%"),
    MetricSpec("start_wrong", "wrong lock", "%"),
    MetricSpec("frames_to_right", "frames until the cable is claimed"),
    MetricSpec("returns", "returns of the cable"),
    MetricSpec("found_again", "found again", "%"),
    MetricSpec("time_to_find", "time to find it again", "s"),
    *_error_specs("", ""),
    *_error_specs("held_", " while held"),
    MetricSpec("nees_mean", "mean NEES"),
    MetricSpec("nees_median", "median NEES"),
    *(
        MetricSpec(f"inside_2_sigma_{axis}", f"truth of {symbol} inside 2σ", "%")
        for axis, symbol, *_ in POSE_COMPONENTS
    ),
    MetricSpec("inside_region", "truth inside the 95 % region", "%"),
    MetricSpec("ms", "processor time per frame", "ms"),
    MetricSpec("ms_p95", "95th percentile of the processor time per frame", "ms"),
)
"""Metrics of a run, in the order of the tables."""

METRICS_BY_NAME: Mapping[str, MetricSpec] = {spec.name: spec for spec in METRIC_TABLE}


def metric_spread(name: str, results: Iterable[RunResult]) -> Spread:
    """Summarise one number over several runs; `name` is a key of `METRICS_BY_NAME`."""
    return spread_of(result.metrics[name] for result in results)
