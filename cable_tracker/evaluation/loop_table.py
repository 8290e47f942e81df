"""Closed loops of a vehicle that follows a cable by the tracker's output: rows, summaries, runs."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.sample_statistics import percentile_of_size, root_mean_square
from cable_tracker.sequences.tables.csv_tables import format_cell, write_csv
from cable_tracker.simulation.rendering.laid_cable import Stretch

TABLE, SUMMARY = "loop.csv", "summary.csv"

SETTLED = 5.0
"""Errors count from here on: before, the vehicle comes from where it was let down [m]."""

LAST_METRES = 5.0
"""A cable that is claimed rightly within the last metres is not lost."""

RIGHT_WITHIN, RIGHT_TURNED = 0.3, math.radians(12.0)
"""A claim is right if offset and heading are no more off [m, rad]."""

GOAL = 0.15
"""Root mean square of the lateral error that is aimed at, at 2 m altitude and 0.5 m/s [m]."""

RUNS, METHODS_TABLE = "runs.csv", "methods.csv"


@dataclass(frozen=True, slots=True)
class LoopRow:
    """One frame of a closed loop; offsets and angles as in `cross_track`.

    Attributes
    ----------
    time : float
        Time since the first frame [s].
    x, y, altitude, yaw : float
        True pose of the vehicle in the world [m, rad]; x runs along the cable's course.
    speed : float
        Speed over the ground [m/s].
    status : str
        The tracker's; empty if it was given no answer.
    mode : str
        The controller's.
    error : float
        True distance to the cable; positive: the cable is to the left [m].
    heading : float
        True direction of the cable from the vehicle's [rad].
    offset : float
        True lateral offset of the cable at x = 0 in base_link [m].
    measured_offset, measured_heading, sigma_offset : float
        Values of `cross_track` [m, rad, m]; NaN without a message.
    """

    time: float
    x: float
    y: float
    altitude: float
    yaw: float
    speed: float
    status: str
    mode: str
    error: float
    heading: float
    offset: float
    measured_offset: float
    measured_heading: float
    sigma_offset: float

    @property
    def is_measured(self) -> bool:
        """Whether there was a `cross_track`."""
        return math.isfinite(self.measured_offset)

    @property
    def is_right(self) -> bool:
        """Whether it was that of the cable."""
        aside = abs(self.measured_offset - self.offset)
        return aside <= RIGHT_WITHIN and abs(self.heading_error) <= RIGHT_TURNED

    @property
    def heading_error(self) -> float:
        """Measured less true heading of the line, which has no sense along it [rad]."""
        return math.remainder(self.measured_heading - self.heading, math.pi)


@dataclass(frozen=True, slots=True)
class LoopSummary:
    """Summary of one run; lengths in metres, times in seconds.

    Attributes
    ----------
    seed, frames : int
        Seed of the run, and number of its frames.
    seconds, way : float
        Duration of the run, and distance travelled along the course.
    reached_end : bool
        Whether it came to the end of the cable.
    rms, percentile_95, most : float
        Statistics of the lateral error, once settled.
    rms_in_sight : float
        RMS of the lateral error without the buried stretch and the search for its end.
    rms_offset, rms_heading : float
        RMS errors of `cross_track` itself, where it was right; the second in degrees.
    answered : float
        Share of the frames that the tracker answered; late ones are dropped in real time.
    measured, wrong : float
        Shares of the frames with a `cross_track`, and of those with one that was not the cable's.
    losses : int
        Number of stops of the controller.
    longest_loss : float
        Longest time in which it did not follow.
    found_again : bool
        After the buried stretch; true without one.
    lost_for_good : bool
        Whether the cable was lost, and not found again before the run ended.
    """

    seed: int
    frames: int
    seconds: float
    way: float
    reached_end: bool
    rms: float
    percentile_95: float
    most: float
    rms_in_sight: float
    rms_offset: float
    rms_heading: float
    answered: float
    measured: float
    wrong: float
    losses: int
    longest_loss: float
    found_again: bool
    lost_for_good: bool

    @property
    def is_within_goal(self) -> bool:
        """Whether the vehicle kept as near to the cable as is aimed at, and did not lose it."""
        return self.rms <= GOAL and not self.lost_for_good


def summarise_loop(
    rows: Sequence[LoopRow], seed: int, length: float, burial: Stretch | None
) -> LoopSummary:
    """Compute the summary of a run.

    Parameters
    ----------
    rows : sequence of LoopRow
        At least one, in the order of time.
    length : float
        Length of the cable's course [m].
    """
    x = np.array([row.x for row in rows])
    errors = np.array([row.error for row in rows])
    follows = np.array([row.mode == "FOLLOWING" for row in rows])
    settled = np.logical_or.accumulate(x >= min(SETTLED, length / 2))
    in_sight = settled & follows
    if burial is not None:
        in_sight &= ~burial.holds(x)
    right = [row for row in rows if row.is_measured and row.is_right]
    measured = [row for row in rows if row.is_measured]
    travelled = float(x.max())
    reached_end = travelled >= length - 1.0
    late = [row for row in right if row.x >= travelled - LAST_METRES and row.mode == "FOLLOWING"]
    losses = _losses(rows)
    return LoopSummary(
        seed=seed,
        frames=len(rows),
        seconds=rows[-1].time - rows[0].time,
        way=travelled,
        reached_end=reached_end,
        rms=root_mean_square(errors[settled]),
        percentile_95=percentile_of_size(errors[settled], 95.0),
        most=percentile_of_size(errors[settled], 100.0),
        rms_in_sight=root_mean_square(errors[in_sight]),
        rms_offset=root_mean_square(np.array([row.measured_offset - row.offset for row in right])),
        rms_heading=math.degrees(root_mean_square(np.array([row.heading_error for row in right]))),
        answered=sum(bool(row.status) for row in rows) / len(rows),
        measured=len(measured) / len(rows),
        wrong=(len(measured) - len(right)) / len(rows),
        losses=len(losses),
        longest_loss=max(losses, default=0.0),
        found_again=burial is None
        or any(row.x > burial.end and row.mode == "FOLLOWING" for row in right),
        lost_for_good=not (reached_end and late),
    )


def _losses(rows: Sequence[LoopRow]) -> list[float]:
    """Return the durations for which the controller did not follow, after it first did [s]."""
    losses, since = [], None
    has_followed = False
    for row in rows:
        if row.mode == "FOLLOWING":
            if since is not None:
                losses.append(row.time - since)
            since, has_followed = None, True
        elif has_followed and since is None:
            since = row.time
    if since is not None:
        losses.append(rows[-1].time - since)
    return losses


def read_summary(path: Path) -> LoopSummary:
    """Read the judgement of a run that `write_records` has written.

    Raises
    ------
    RecordingError
        The file is missing, or something else.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            row = next(csv.DictReader(file))
        kinds = get_type_hints(LoopSummary)
        return LoopSummary(**{name: _value(row[name], kind) for name, kind in kinds.items()})
    except (OSError, StopIteration, KeyError, TypeError, ValueError, csv.Error) as error:
        raise RecordingError(
            f"{path}: this is no summary of a closed loop; run `cable-tracker loop` again"
        ) from error


def _value(cell: str, kind: type) -> Any:  # noqa: ANN401
    if kind is bool:
        return cell == "true"
    return float(cell or math.nan) if kind is float else kind(cell)


@dataclass(frozen=True, slots=True)
class LoopOutcome:
    """Outcome of one run.

    Attributes
    ----------
    method : str
        Name of the method that tracked.
    seed : int
        Seed of the run.
    summary : LoopSummary or None
        Summary of the run; None if it did not come to an end.
    failure : str
        Reason for its failure, in one line; empty otherwise.
    """

    method: str
    seed: int
    summary: LoopSummary | None
    failure: str = ""


MEASURES: dict[str, tuple[Callable[..., np.floating], str]] = {
    "way": (np.median, "way"),
    "rms": (np.median, "rms"),
    "worst_rms": (np.max, "rms"),
    "most": (np.max, "most"),
    "rms_in_sight": (np.median, "rms_in_sight"),
    "rms_offset": (np.median, "rms_offset"),
    "rms_heading": (np.median, "rms_heading"),
    "measured": (np.mean, "measured"),
    "wrong": (np.mean, "wrong"),
    "losses": (np.mean, "losses"),
    "longest_loss": (np.max, "longest_loss"),
}
"""Columns of a method's totals that are taken over its runs: how, and which field of
`LoopSummary`."""


def totals_by_method(outcomes: Sequence[LoopOutcome]) -> list[dict[str, Any]]:
    """Sum the runs of each method up, in the order in which the methods appear first.

    Returns
    -------
    list of dict
        Columns of the table of methods, in order: the name; how many runs there are, have failed,
        did not lose the cable for good, found it again, are within the goal; `MEASURES` over those
        that came to an end, NaN without any.
    """
    methods = dict.fromkeys(outcome.method for outcome in outcomes)
    return [_totals(name, [each for each in outcomes if each.method == name]) for name in methods]


def _totals(method: str, outcomes: Sequence[LoopOutcome]) -> dict[str, Any]:
    ended = [outcome.summary for outcome in outcomes if outcome.summary is not None]
    return {
        "method": method,
        "runs": len(outcomes),
        "failed": len(outcomes) - len(ended),
        "kept": sum(not summary.lost_for_good for summary in ended),
        "found_again": sum(summary.found_again for summary in ended),
        "within_goal": sum(summary.is_within_goal for summary in ended),
        **{name: _over(ended, *measure) for name, measure in MEASURES.items()},
    }


def _over(ended: Sequence[LoopSummary], measure: Callable[..., np.floating], name: str) -> float:
    values = np.array([getattr(summary, name) for summary in ended], dtype=np.float64)
    values = values[np.isfinite(values)]
    return float(measure(values)) if values.size else math.nan


def write_runs(path: Path, outcomes: Sequence[LoopOutcome]) -> None:
    """Write one line for each run as CSV; of a run that failed, the reason alone."""
    names = [field.name for field in fields(LoopSummary) if field.name != "seed"]
    rows = []
    for outcome in outcomes:
        cells = [
            "" if outcome.summary is None else format_cell(getattr(outcome.summary, name))
            for name in names
        ]
        rows.append([outcome.method, outcome.seed, *cells, outcome.failure])
    write_csv(path, ["method", "seed", *names, "failure"], rows)


def write_methods(path: Path, totals: Sequence[dict[str, Any]]) -> None:
    """Write one line for each method as CSV."""
    rows = (map(format_cell, each.values()) for each in totals)
    write_csv(path, totals[0], rows)
