"""Closed loops of a vehicle that follows a cable by the tracker's output: rows and summary."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.sample_statistics import percentile_of_size, root_mean_square
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
