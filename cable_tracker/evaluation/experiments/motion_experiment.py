"""Worth of odometry to the filter, and cost of wrong odometry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from cable_tracker.cable.parameters.presets import preset
from cable_tracker.campaigns.runner import run_all
from cable_tracker.campaigns.settings import CampaignSettings
from cable_tracker.evaluation.evaluation_sequences import EvaluationSequence, frames_in_all
from cable_tracker.evaluation.experiments.aided import AidedFilter, OdometryFault
from cable_tracker.evaluation.experiments.experiment import ExperimentResult
from cable_tracker.evaluation.result_table import ResultTable, format_number, median_and_range
from cable_tracker.evaluation.run_metrics import METRICS_BY_NAME
from cable_tracker.evaluation.runs import MethodRun, RunResult, Start, chosen, metric_spread
from cable_tracker.evaluation.sample_statistics import spread_of

MOTION_SEQUENCES = ("S1", "S2", "S6")
METRICS = ("rmse_d", "rmse_alpha", "median_alpha", "wrong_claims", "silence")

FAULT_SEEDS = 3
"""Number of seeds, from the first, on which broken odometry is run, to save time."""

BRIEF_COLUMNS = 9


@dataclass(frozen=True, slots=True)
class MotionSetting:
    """One row of the table.

    Attributes
    ----------
    name : str
        Name of the difficulty; rows with one name are compared.
    fault : OdometryFault or None
        Fault of odometry; None: no odometry.
    share : float
        Share of the preset's particles.
    every : int
        Interval of the frames that are seen.
    preset : str
        Preset of the filter's parameters.
    """

    name: str
    fault: OdometryFault | None
    share: float = 1.0
    every: int = 1
    preset: str = "default"

    @property
    def label(self) -> str:
        """Label of the row beside `name`."""
        return "none" if self.fault is None else self.fault.value

    @property
    def is_broken(self) -> bool:
        """Whether there is odometry with a fault."""
        return self.fault not in (None, OdometryFault.NONE)

    def make_run(self, scenario: str, seed: int) -> MethodRun:
        """Return a fresh run on the dive of a seed."""
        whole = preset(self.preset)
        parameters = whole.replaced({"particle_count": round(self.share * whole.particle_count)})
        name = f"{self.preset}/{self.name}/{self.label}"
        maker = AidedFilter(name, parameters, scenario, self.fault)
        return MethodRun(name, maker.make, seed, Start.TRUTH)


HARDER = (("as it is", 1.0, 1), ("half the particles", 0.5, 1), ("half the frame rate", 1.0, 2))
"""Name, share of the particles, and every how manieth frame is seen."""

SETTINGS = (
    *(
        MotionSetting(name, fault, share, every)
        for name, share, every in HARDER
        for fault in (None, *OdometryFault)
    ),
    *(
        MotionSetting(name, fault, share, every, "thesis")
        for name, share, every in HARDER
        for fault in (None, OdometryFault.NONE)
    ),
)
"""Sound odometry against none with `default` and `thesis`; with `default` all that may be wrong."""


@dataclass(frozen=True, slots=True)
class _Dive:
    """One scenario with one seed: all its settings in one process, which share the frames."""

    sequence: EvaluationSequence
    seed: int
    settings: tuple[MotionSetting, ...]

    def run(self, advance: Callable[[int], None]) -> list[RunResult]:
        runs = [setting.make_run(self.sequence.name, self.seed) for setting in self.settings]
        for frame in self.sequence.frames(self.seed):
            for setting, run in zip(self.settings, runs, strict=True):
                if frame.index % setting.every == 0:
                    run.process(frame)
            advance(1)
        return [run.result(self.sequence.name) for run in runs]


@dataclass(frozen=True, slots=True)
class MotionExperiment:
    """Follow scenarios from their true beginning, with and without odometry.

    Attributes
    ----------
    seeds : tuple of int
        Each makes another dive of the same kind.
    sequences : tuple of EvaluationSequence
        Sequences to run on.
    settings : tuple of MotionSetting
        The rows.
    """

    seeds: tuple[int, ...]
    sequences: tuple[EvaluationSequence, ...]
    settings: tuple[MotionSetting, ...] = SETTINGS

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through."""
        counts = (sequence.frame_count() for sequence in self.sequences)
        return frames_in_all(counts, len(self.seeds))

    def run(self, settings: CampaignSettings, advance: Callable[[int], None]) -> ExperimentResult:
        """Run it; the results do not depend on the number of workers."""
        dives = [
            _Dive(sequence, seed, self._settings_of(seed))
            for sequence in self.sequences
            for seed in self.seeds
        ]
        results = run_all(dives, settings, advance=advance)
        by_setting: dict[MotionSetting, list[RunResult]] = {each: [] for each in self.settings}
        for dive, runs in zip(dives, results, strict=True):
            for setting, run in zip(dive.settings, runs, strict=True):
                by_setting[setting].append(run)
        presets = dict.fromkeys(setting.preset for setting in self.settings)
        tables = tuple(self._table(name, by_setting) for name in presets)
        return ExperimentResult("What odometry is worth to the filter", tables)

    def _settings_of(self, seed: int) -> tuple[MotionSetting, ...]:
        with_faults = seed in self.seeds[:FAULT_SEEDS]
        return tuple(each for each in self.settings if with_faults or not each.is_broken)

    def _table(self, name: str, by_setting: dict[MotionSetting, list[RunResult]]) -> ResultTable:
        headings = (
            "setting", "odometry", "runs", "frames lost", "without odometry", "frames lost [%]",
            *(f"{each.name}: frames lost [%]" for each in self.sequences),
            *(METRICS_BY_NAME[metric].title for metric in METRICS),
        )  # fmt: skip
        rows = tuple(
            self._row(setting, runs, _without_odometry(setting, runs, by_setting))
            for setting, runs in by_setting.items()
            if setting.preset == name
        )
        note = (
            "*frames lost* are those of all runs together, and beside them those of the same dives"
            " without odometry; for each sequence, median over the runs (least – most). The other"
            " numbers: means over the sequences, of medians over the runs. The odometry is a twist"
            " at 50 Hz with noise, biases and a scale error; see `EXPERIMENT_ERRORS`."
        )
        return ResultTable(
            headings, rows, f"Preset `{name}`", f"{name}.csv", (note,), BRIEF_COLUMNS
        )

    def _row(
        self, setting: MotionSetting, runs: Sequence[RunResult], without: Sequence[RunResult]
    ) -> tuple[str, ...]:
        groups = [chosen(runs, sequence=each.name) for each in self.sequences]
        lost = _lost_frames(runs)
        visible = sum(run.metrics["visible"] for run in runs)
        return (
            setting.name,
            setting.label,
            str(len(runs)),
            str(lost),
            str(_lost_frames(without)) if without else "–",
            format_number(100.0 * lost / max(visible, 1), "%"),
            *(median_and_range(metric_spread("lost", group), "%") for group in groups),
            *(_mean_of_medians(metric, groups) for metric in METRICS),
        )


def _without_odometry(
    setting: MotionSetting,
    runs: Sequence[RunResult],
    by_setting: dict[MotionSetting, list[RunResult]],
) -> list[RunResult]:
    """Return the runs on the same dives that only lack odometry."""
    dives = {(run.sequence, run.seed) for run in runs}
    others = by_setting.get(replace(setting, fault=None), [])
    return [run for run in others if (run.sequence, run.seed) in dives]


def _lost_frames(runs: Sequence[RunResult]) -> int:
    return sum(int(run.trace.lost.sum()) for run in runs)


def _mean_of_medians(metric: str, groups: Sequence[Sequence[RunResult]]) -> str:
    medians = (metric_spread(metric, group).median for group in groups)
    return format_number(spread_of(medians).mean, METRICS_BY_NAME[metric].unit)
