"""How well a vehicle kept its distance behind a target: the table of a chase, and its figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import yaml
from matplotlib.figure import Figure

from cable_tracker.atomic_output import write_bytes
from cable_tracker.evaluation.sample_statistics import mean, median
from cable_tracker.sequences.tables.csv_tables import write_records
from cable_tracker.visualisation.plots import write_figure

TABLE, SUMMARY, PLOT = "chase.csv", "summary.yaml", "distance.png"

KEPT = 1.0
"""A distance that is off by less is kept [m]."""

FOUND_AGAIN = 3.0
"""Time after its return within which a claimed target counts as found again [s]."""


@dataclass(frozen=True, slots=True)
class ChaseRow:
    """One frame of a chase.

    Attributes
    ----------
    time : float
        Time since the start [s].
    distance : float
        True distance to the target [m].
    is_visible : bool
        Whether anything of it can be seen.
    is_claimed : bool
        Whether the tracker claims it.
    range, range_sigma : float
        Estimated distance and its standard deviation; NaN without an estimate [m].
    off : float
        Distance between the estimated position and the true one [m]; NaN likewise.
    """

    time: float
    distance: float
    is_visible: bool
    is_claimed: bool
    range: float
    range_sigma: float
    off: float


@dataclass(frozen=True, slots=True)
class ChaseSummary:
    """Figures of a chase.

    Attributes
    ----------
    seconds : float
        Duration of the run [s].
    frames : int
        Number of frames.
    mean_distance, worst_distance : float
        Mean and largest true distance [m].
    kept : float
        Share of the frames in which the distance is off by less than a metre.
    claimed_in_view, claimed_while_absent : float
        Shares of the claimed frames, of those with and of those without the target in view.
    times_hidden, times_found_again : int
        Numbers of disappearances, and of those after which it was soon claimed again.
    range_error : float
        Median of the relative error of the range.
    within_two_sigmas : float
        Share of the ranges whose truth is within two standard deviations.
    """

    seconds: float
    frames: int
    mean_distance: float
    worst_distance: float
    kept: float
    claimed_in_view: float
    claimed_while_absent: float
    times_hidden: int
    times_found_again: int
    range_error: float
    within_two_sigmas: float


def summarise_chase(rows: Sequence[ChaseRow], wanted: float) -> ChaseSummary:
    """Return the figures of a chase in which a distance was to be kept [m]."""
    distances = np.array([row.distance for row in rows])
    visible = np.array([row.is_visible for row in rows])
    claimed = np.array([row.is_claimed for row in rows])
    ranges = np.array([row.range for row in rows])
    sigmas = np.array([row.range_sigma for row in rows])
    known = np.isfinite(ranges) & visible
    returns = np.flatnonzero(visible[1:] & ~visible[:-1]) + 1
    return ChaseSummary(
        seconds=rows[-1].time - rows[0].time,
        frames=len(rows),
        mean_distance=float(distances.mean()),
        worst_distance=float(distances.max()),
        kept=float(np.mean(np.abs(distances - wanted) < KEPT)),
        claimed_in_view=mean(claimed[visible]),
        claimed_while_absent=mean(claimed[~visible]),
        times_hidden=int((~visible[1:] & visible[:-1]).sum()),
        times_found_again=sum(
            _is_found(rows, int(start)) for start in returns if visible[:start].any()
        ),
        range_error=median(np.abs(ranges[known] / distances[known] - 1.0)),
        within_two_sigmas=mean(np.abs(ranges - distances)[known] < 2.0 * sigmas[known]),
    )


def _is_found(rows: Sequence[ChaseRow], start: int) -> bool:
    end = rows[start].time + FOUND_AGAIN
    return any(row.is_claimed and row.is_visible for row in rows[start:] if row.time <= end)


def write_chase(folder: Path, rows: Sequence[ChaseRow], summary: ChaseSummary) -> None:
    """Write table, figures and a plot of the distance into a folder.

    Raises
    ------
    OutputError
        A file cannot be written.
    """
    write_records(folder / TABLE, ChaseRow, rows)
    text = yaml.safe_dump(asdict(summary), sort_keys=False)
    write_bytes(folder / SUMMARY, text.encode())
    figure = Figure(figsize=(9.0, 3.2))
    axes = figure.subplots()
    times = [row.time for row in rows]
    axes.plot(times, [row.distance for row in rows], label="true distance")
    axes.plot(times, [row.range for row in rows], label="range told", linewidth=0.8)
    hidden = [not row.is_visible for row in rows]
    top = 1.1 * max(row.distance for row in rows)
    axes.fill_between(times, 0.0, top, where=hidden, alpha=0.2, label="out of view")
    axes.set_ylim(0.0, top)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("[m]")
    axes.legend(loc="lower right")
    figure.tight_layout()
    write_figure(folder / PLOT, figure)
