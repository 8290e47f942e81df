"""What odometry is worth to the filter, and what it costs when it is wrong."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.cable.presets import preset
from cable_tracker.evaluation.aided import AidedFilter, OdometryFault
from cable_tracker.evaluation.experiment_result import ExperimentResult, ResultTable
from cable_tracker.evaluation.frames import ScenarioSequence, scenario_sequences
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.evaluation.metric_table import METRICS_BY_NAME, metric_spread
from cable_tracker.evaluation.report import format_number
from cable_tracker.evaluation.runs import MethodRun, RunResult, Start

MOTION_SEQUENCES = ("S1", "S2", "S6")
METRICS = ("lost", "silence", "wrong_claims", "rmse_d", "rmse_alpha", "ms")


@dataclass(frozen=True, slots=True)
class MotionSetting:
    """One row of the table.

    Attributes
    ----------
    name : str
        What is made harder; the same for rows to compare.
    fault : OdometryFault or None
        What is wrong with odometry; None: there is none.
    share : float
        Of the preset's particles.
    every : int
        Only every so many frames are seen.
    """

    name: str
    fault: OdometryFault | None
    share: float = 1.0
    every: int = 1

    @property
    def label(self) -> str:
        """What stands in the table beside `name`."""
        return "none" if self.fault is None else self.fault.value

    def make_run(self, scenario: str, seed: int) -> MethodRun:
        """Return a fresh run on the dive of a seed."""
        default = preset("default")
        count = round(self.share * default.particle_count)
        parameters = default.replaced({"particle_count": count})
        name = f"{self.name}/{self.label}"
        maker = (
            ConfiguredFilter(name, parameters)
            if self.fault is None
            else AidedFilter(name, parameters, scenario, self.fault)
        )
        return MethodRun(name, maker.make, seed, Start.TRUTH)


SETTINGS = (
    *(
        MotionSetting(name, fault, share, every)
        for name, share, every in (
            ("as it is", 1.0, 1),
            ("half the particles", 0.5, 1),
            ("half the frame rate", 1.0, 2),
        )
        for fault in (None, OdometryFault.NONE)
    ),
    *(
        MotionSetting("as it is", fault)
        for fault in (
            OdometryFault.FROZEN,
            OdometryFault.HANGING,
            OdometryFault.WRONG_STAMPS,
            OdometryFault.TURNED,
        )
    ),
)
"""Sound odometry against none, three times, and then what may be wrong with it."""


@dataclass(frozen=True, slots=True)
class MotionExperiment:
    """Follow scenarios from their true beginning, with and without odometry.

    Attributes
    ----------
    seeds : tuple of int
        Each makes another dive of the same kind.
    sequences : tuple of ScenarioSequence
        What to follow.
    settings : tuple of MotionSetting
        The rows.
    """

    seeds: tuple[int, ...]
    sequences: tuple[ScenarioSequence, ...] = scenario_sequences(MOTION_SEQUENCES)
    settings: tuple[MotionSetting, ...] = SETTINGS

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through."""
        return sum(sequence.frame_count() or 0 for sequence in self.sequences) * len(self.seeds)

    def run(self, workers: int, advance: Callable[[int], None]) -> ExperimentResult:
        """Run it, in one process whatever `workers` says."""
        del workers
        results: list[list[RunResult]] = [[] for _ in self.settings]
        for sequence in self.sequences:
            for seed in self.seeds:
                for kept, result in zip(results, self._runs(sequence, seed, advance), strict=True):
                    kept.append(result)
        specs = [METRICS_BY_NAME[name] for name in METRICS]
        headings = (
            "setting", "odometry", "frames lost",
            *(f"{spec.label} [{spec.unit}]" for spec in specs),
            *(f"{each.name}: frames lost [%]" for each in self.sequences),
        )  # fmt: skip
        rows = (
            self._row(setting, runs) for setting, runs in zip(self.settings, results, strict=True)
        )
        note = (
            "Means over the sequences, of means over the runs; *frames lost* counts those of all"
            " runs together. The odometry is a twist at 50 Hz with noise, biases and a scale error;"
            " see `InstrumentNoise`."
        )
        table = ResultTable(headings, tuple(rows), notes=(note,))
        return ExperimentResult("What odometry is worth to the filter", (table,))

    def _runs(
        self, sequence: ScenarioSequence, seed: int, advance: Callable[[int], None]
    ) -> list[RunResult]:
        runs = [setting.make_run(sequence.name, seed) for setting in self.settings]
        for frame in sequence.frames(seed):
            for setting, run in zip(self.settings, runs, strict=True):
                if frame.index % setting.every == 0:
                    run.process(frame)
            advance(1)
        return [run.result(sequence.name) for run in runs]

    def _row(self, setting: MotionSetting, runs: Sequence[RunResult]) -> tuple[str, ...]:
        groups = [[r for r in runs if r.sequence == each.name] for each in self.sequences]
        cells = []
        for name in METRICS:
            spec = METRICS_BY_NAME[name]
            means = [metric_spread(spec, [run.metrics for run in group]).mean for group in groups]
            cells.append(format_number(float(np.nanmean(means)), spec.unit))
        lost = METRICS_BY_NAME["lost"]
        return (
            setting.name,
            setting.label,
            str(sum(int(run.trace.lost.sum()) for run in runs)),
            *cells,
            *(
                format_number(metric_spread(lost, [run.metrics for run in group]).mean, "%")
                for group in groups
            ),
        )
