"""Whether crisp strips of any width, place, angle and skew are found at once, and how wide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from cable_tracker.cable.model.state import WIDTH
from cable_tracker.evaluation.evaluation_sequences import StripSequence
from cable_tracker.evaluation.experiments.experiment import CampaignExperiment, ExperimentResult
from cable_tracker.evaluation.result_table import ResultTable, format_number
from cable_tracker.evaluation.runs import Campaign, RunResult, Start, chosen
from cable_tracker.evaluation.sample_statistics import mean
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH

STRIPS_PER_SEED = 100
"""Number of strips drawn for each seed of the experiment: five seeds make 500."""

WIDTH_BINS = (4.0, 8.0, 16.0, 32.0, 64.0, 120.0, 200.0)
"""Limits of the rows of the table [px at 320 px]."""

WIDTH_TOLERANCE = 0.1
"""The width is right if it is off by no more than this share."""

HEADINGS = (
    "method", "width [px at 320 px]", "strips", "found [%]", "found, width within 10 % [%]",
    "claimed wrongly only [%]",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class StripsExperiment(CampaignExperiment):
    """Show methods crisp strips from cold starts, ten frames each.

    Attributes
    ----------
    seeds : tuple of int
        Each draws `STRIPS_PER_SEED` strips.
    sequence : StripSequence
        Sequence of strips to run on.
    methods : tuple of str
        Keys of `METHODS`.
    """

    seeds: tuple[int, ...]
    sequence: StripSequence
    methods: tuple[str, ...] = ("default",)

    def campaign(self) -> Campaign:
        """Return what is run."""
        strips = tuple(
            seed * STRIPS_PER_SEED + place
            for seed in self.seeds
            for place in range(STRIPS_PER_SEED)
        )
        return Campaign(self.methods, (self.sequence,), strips, Start.RANDOM)

    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into tables and figures."""
        rows = []
        for method in self.methods:
            runs = chosen(results, method=method)
            for low, high in pairwise(WIDTH_BINS):
                inside = [run for run in runs if low <= _width(run) < high]
                rows.append((method, f"{low:g} to {high:g}", *_cells(inside)))
            rows.append((method, "all", *_cells(runs)))
        return ExperimentResult(
            f"Crisp strips found within {self.sequence.frame_count()} frames of a cold start",
            (ResultTable(HEADINGS, tuple(rows)),),
        )


def _width(run: RunResult) -> float:
    """Return the width of the strip [px at 320 px]."""
    width = float(run.trace.truths[0, WIDTH])
    return width * REFERENCE_WIDTH / float(run.trace.image_widths[0])


def is_found(run: RunResult) -> bool:
    """Tell whether the strip was claimed rightly in any frame."""
    return bool(run.trace.useful.any())


def is_measured(run: RunResult) -> bool:
    """Tell whether it is claimed rightly in the last frame, and its width is right."""
    trace = run.trace
    error = abs(float(trace.errors[-1, WIDTH]))
    right = error <= WIDTH_TOLERANCE * float(trace.truths[-1, WIDTH])
    return bool(trace.useful[-1]) and right


def _cells(runs: Sequence[RunResult]) -> tuple[str, ...]:
    wrong = [bool(run.trace.claimed.any()) and not is_found(run) for run in runs]
    shares = ([is_found(run) for run in runs], [is_measured(run) for run in runs], wrong)
    numbers = (100.0 * mean(each) for each in shares)
    return str(len(runs)), *(format_number(number, "%") for number in numbers)
