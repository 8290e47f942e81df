"""Table of a dive frame by frame, in columns; a row takes 144 bytes on disk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.survey.memory_mapped import Disk, GrowingArray
from cable_tracker.tracking import status
from cable_tracker.tracking.status import TrackingStatus

PROFILE_BINS = 12
"""Places along the cable in one picture at which it is judged whether it can be seen."""

ROW = np.dtype(
    [
        ("frame", "i8"),
        ("stamp", "i8"),
        ("status", "i1"),
        ("presence", "f4"),
        ("d", "f4"),
        ("alpha", "f4"),
        ("w", "f4"),
        ("beta", "f4"),
        ("offset", "f4"),
        ("sigma_offset", "f4"),
        ("heading", "f4"),
        ("sigma_heading", "f4"),
        ("diameter", "f4"),
        ("reason", "i2"),
        ("look", "f4"),
        ("aside", "f4"),
        ("aside_variance", "f4"),
        ("aside_heading", "f4"),
        ("heading_variance", "f4"),
        ("half_view", "f4"),
        ("altitude", "f4"),
        ("roll", "f4"),
        ("pitch", "f4"),
        ("again", "i1"),
        ("profile_ahead", "f2", (PROFILE_BINS,)),
        ("profile_score", "f2", (PROFILE_BINS,)),
    ]
)
"""Columns: see `FrameTable`."""

EMPTY = np.zeros((), ROW)
"""A row of which nothing is known."""

for _name in ROW.names or ():
    if ROW[_name].base.kind == "f":
        EMPTY[_name] = np.nan

STATUSES = (
    TrackingStatus.INITIALISING.value,
    TrackingStatus.TRACKING.value,
    TrackingStatus.LOST.value,
    status.REFUSED,
)
TRACKING = STATUSES.index(TrackingStatus.TRACKING.value)
REFUSED = STATUSES.index(status.REFUSED)

NOT_AGAIN, HIDDEN, SEEN = range(3)
"""Result of re-detection: none was made, the cable is hidden, the cable is seen."""

AGAIN = ("", "hidden", "seen")
"""What stands for these in a table."""

Rows = npt.NDArray[Any]

FrameRow = np.void
"""A row of `FrameTable`."""


def is_claimed(rows: Rows) -> npt.NDArray[np.bool_]:
    """Tell for rows (N,) whether they say where the cable is: the tracker, or re-detection."""
    again = rows["again"]
    claimed: npt.NDArray[np.bool_] = (rows["status"] == TRACKING) & (again == NOT_AGAIN)
    claimed |= again == SEEN
    return claimed


def is_measured(rows: Rows) -> npt.NDArray[np.bool_]:
    """Tell for rows (N,) whether they say in metres where the cable is."""
    measured: npt.NDArray[np.bool_] = is_claimed(rows) & np.isfinite(rows["aside"])
    return measured


def is_withheld(rows: Rows) -> npt.NDArray[np.bool_]:
    """Tell for rows (N,) whether the tracker claims a cable there whose metres are not known."""
    withheld: npt.NDArray[np.bool_] = is_claimed(rows) & (rows["reason"] > 0)
    return withheld


@dataclass(frozen=True, slots=True)
class CrossingObservation:
    """Another line that lies across the cable in one picture.

    Attributes
    ----------
    row : int
        Row of the table.
    ahead : float
        x of the place where they cross, in the vehicle's level frame [m].
    angle : float
        Angle of the crossing line in the vehicle's frame, in (-pi/2, pi/2] [rad].
    """

    row: int
    ahead: float
    angle: float


class FrameTable:
    """Rows of a dive.

    The cable beside the vehicle is a line in its level frame: at x = `look`, where the camera
    looks, it is at y = `aside`, with direction `heading`; `aside_variance`, `aside_heading` and
    `heading_variance` are their covariance [m, rad]. All NaN where there are no metres; `reason`
    says why, by its number in `reasons`. `half_view` is how far to either side the camera sees at
    x = `look` [m]; `altitude`, `roll` and `pitch` are the vehicle's [m, rad]. `profile_score` says
    at x = `profile_ahead` how clearly both borders are there. Where `again` is not `NOT_AGAIN`, a
    re-detection has written the cable's columns: see `redetection`.

    Parameters
    ----------
    disk : Disk
        Allocator of the rows.

    Attributes
    ----------
    reasons : list of str
        Reasons for missing metres; the first is "".
    crossings : list of CrossingObservation
        Detected lines across the cable.
    """

    def __init__(self, disk: Disk) -> None:
        self.reasons = [""]
        self.crossings: list[CrossingObservation] = []
        self._rows = GrowingArray(disk, EMPTY)

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def rows(self) -> Rows:
        """All rows, dtype `ROW`, shape (N,)."""
        return self._rows.rows()

    def append(self) -> Any:  # noqa: ANN401  A row of a structured array has no type.
        """Add an empty row, and return it to be filled."""
        return self._rows.append()

    def reason_number(self, reason: str) -> int:
        """Return the number of a reason, which is remembered."""
        if reason not in self.reasons:
            self.reasons.append(reason)
        return self.reasons.index(reason)


class Samples:
    """Readings with stamps that grow, in columns.

    Parameters
    ----------
    width : int
        Numbers of a reading.
    disk : Disk
        Allocator of the rows.
    """

    def __init__(self, width: int, disk: Disk) -> None:
        reading = np.dtype([("stamp", "i8"), ("values", "f8", (width,))])
        self._readings = disk.growing(reading)

    def __len__(self) -> int:
        return len(self._readings)

    def add(self, stamp: int, values: Sequence[float]) -> None:
        """Add a reading."""
        reading = self._readings.append()
        reading["stamp"], reading["values"] = stamp, values

    def arrays(self) -> tuple[IndexArray, FloatArray]:
        """Return stamps (N,) [ns] and readings (N, width)."""
        readings = self._readings.rows()
        return readings["stamp"], readings["values"]
