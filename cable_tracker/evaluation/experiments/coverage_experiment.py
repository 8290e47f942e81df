"""Whether sigma and covariance of the preset `default` are as large as its errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import DISTANCE, POSE_SIZE, POSE_SYMBOLS, WIDTH
from cable_tracker.evaluation.consistency import (
    REGION_NEES,
    coverage,
    nees,
    sigma_factors,
)
from cable_tracker.evaluation.evaluation_sequences import (
    THESIS_SEQUENCES,
    EvaluationSequence,
    reported_worlds,
    simulated_sequences,
)
from cable_tracker.evaluation.experiments.experiment import CampaignExperiment, ExperimentResult
from cable_tracker.evaluation.result_table import ResultTable, format_number
from cable_tracker.evaluation.runs import Campaign, RunResult, Start, chosen
from cable_tracker.evaluation.sample_statistics import mean, median
from cable_tracker.evaluation.trace import Trace

METHOD = "default"

PROBABILITY = 0.95
"""Probability of the central intervals, which reach 1.96 sigma, and of the region of all four."""

HEADINGS = (
    "sequence", "frames", "d [%]", "alpha [%]", "w [%]", "beta [%]", "region [%]", "NEES",
    "bias of d [px]", "bias of w [px]", "dives below 95 %",
)  # fmt: skip
FACTOR_HEADINGS = ("sequence", *POSE_SYMBOLS)
BRIEF_COLUMNS = 7

NOTE = (
    "Over the frames in which a visible cable is claimed, and rightly: share of the truths inside"
    " 1.96 sigma, and inside the region of all four that should hold 95 %; median NEES, 3.36 if the"
    " covariance is honest; bias is the median of estimate minus truth. The last column: dives with"
    " less than 95 % inside the region, of all in which there is such a frame."
)
FACTOR_NOTE = (
    "The 95th percentile of |error| / sigma over the same frames, over 1.96: above 1 sigma is too"
    " small, below 1 too large."
)


@dataclass(frozen=True, slots=True)
class SequenceGroup:
    """Sequences that have a row together, and one each.

    Attributes
    ----------
    name : str
        Name of the group of sequences.
    sequences : tuple of EvaluationSequence
        At least one.
    notes : tuple of str
        Remarks below the table.
    """

    name: str
    sequences: tuple[EvaluationSequence, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class CoverageExperiment(CampaignExperiment):
    """Follow cables with the preset `default` from the true beginning.

    Attributes
    ----------
    seeds : tuple of int
        Seeds; each makes another dive of every sequence.
    groups : tuple of SequenceGroup
        Sequences to follow.
    """

    seeds: tuple[int, ...]
    groups: tuple[SequenceGroup, ...]

    def campaign(self) -> Campaign:
        """Return what is run."""
        sequences = tuple(each for group in self.groups for each in group.sequences)
        return Campaign((METHOD,), sequences, self.seeds, Start.TRUTH)

    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into tables and figures."""
        rows = [row for group in self.groups for row in _rows_of(group, results)]
        notes = tuple(note for group in self.groups for note in group.notes)
        shares = tuple((name, *coverage_cells(traces)) for name, traces in rows)
        factors = tuple(
            (name, *(format_number(float(each), "") for each in sigma_factors(traces, PROBABILITY)))
            for name, traces in rows
        )
        return ExperimentResult(
            "Truths inside the stated covariance, from the truth",
            (
                ResultTable(
                    HEADINGS, shares, "Coverage", "coverage.csv", (NOTE, *notes), BRIEF_COLUMNS
                ),
                ResultTable(
                    FACTOR_HEADINGS,
                    factors,
                    "Factor by which sigma would hold 95 %",
                    "factors.csv",
                    (FACTOR_NOTE,),
                ),
            ),
        )


def reported_coverage(seeds: tuple[int, ...], limit: int | None = None) -> CoverageExperiment:
    """Return the experiment on the worlds to report on that have a cable, and on S1 to S6.

    `limit`: number of frames used of each; None: all.
    """
    worlds, notes = reported_worlds(limit, with_cable=True)
    groups = (
        SequenceGroup("all `report_*` with a cable", worlds, notes),
        SequenceGroup("S1 to S6", simulated_sequences(THESIS_SEQUENCES, limit)),
    )
    return CoverageExperiment(seeds, groups)


def _rows_of(
    group: SequenceGroup, results: Sequence[RunResult]
) -> list[tuple[str, tuple[Trace, ...]]]:
    """Return names and rightly claimed frames, of the group and of each sequence in it."""
    by_name = {
        each.name: tuple(
            run.trace.where(run.trace.useful) for run in chosen(results, sequence=each.name)
        )
        for each in group.sequences
    }
    together = tuple(trace for traces in by_name.values() for trace in traces)
    return [(group.name, together), *((f"`{name}`", each) for name, each in by_name.items())]


def coverage_cells(traces: Sequence[Trace]) -> tuple[str, ...]:
    """Return the cells of `HEADINGS` but for the name, over all frames of some dives.

    Parameters
    ----------
    traces : sequence of Trace
        The frames of one dive each in which a visible cable is claimed; there may be none.
    """
    dives = [trace for trace in traces if len(trace)]
    errors = np.concatenate([np.empty((0, POSE_SIZE)), *(dive.errors for dive in dives)])
    squares = [nees(dive.errors, dive.covariances) for dive in dives]
    pooled = np.concatenate([np.empty(0), *squares])
    shares = (*coverage(dives, np.array([PROBABILITY]))[0], _share_in_region(pooled))
    biases = (median(errors[:, column]) for column in (DISTANCE, WIDTH))
    below = sum(_share_in_region(each) < PROBABILITY for each in squares)
    return (
        str(len(errors)),
        *(format_number(100.0 * float(share), "%") for share in shares),
        format_number(median(pooled), ""),
        *(format_number(bias, "px") for bias in biases),
        f"{below} of {len(dives)}",
    )


def _share_in_region(squares: FloatArray) -> float:
    return mean(squares <= REGION_NEES)
