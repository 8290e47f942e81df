"""What a dive says frame by frame, in columns; a row takes 144 bytes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from cable_tracker.arrays import FloatArray, IndexArray

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

STATUSES = ("INITIALISING", "TRACKING", "LOST", "REFUSED")
TRACKING = STATUSES.index("TRACKING")

NOT_AGAIN, HIDDEN, SEEN = range(3)
"""What a second look says: there was none, the cable is not to be seen, it is."""

GROWTH = 4096

Rows = npt.NDArray[Any]


def is_claimed(rows: Rows) -> npt.NDArray[np.bool_]:
    """Tell for rows (N,) whether they say where the cable is: the tracker, or a second look."""
    again = rows["again"]
    claimed: npt.NDArray[np.bool_] = (rows["status"] == TRACKING) & (again == NOT_AGAIN)
    claimed |= again == SEEN
    return claimed


@dataclass(frozen=True, slots=True)
class CrossingSight:
    """Another line that lies across the cable in one picture.

    Attributes
    ----------
    row : int
        Of the table.
    ahead : float
        x of the place where they cross, in the vehicle's level frame [m].
    angle : float
        Of the other line against the vehicle, in (-pi/2, pi/2] [rad].
    """

    row: int
    ahead: float
    angle: float


@dataclass(slots=True, eq=False)
class FrameTable:
    """Rows of a dive.

    The cable beside the vehicle is a line in its level frame: at x = `look`, where the camera
    looks, it is at y = `aside`, with direction `heading`; `aside_variance`, `aside_heading` and
    `heading_variance` are their covariance [m, rad]. All NaN where there are no metres; `reason`
    says why, by its number in `reasons`. `half_view` is how far to either side the camera sees at
    x = `look` [m]; `altitude`, `roll` and `pitch` are the vehicle's [m, rad]. `profile_score` says
    at x = `profile_ahead` how clearly both borders are there. Where `again` is not `NOT_AGAIN`, a
    second look has written the cable's columns: see `second_look`.

    Attributes
    ----------
    reasons : list of str
        Why there are no metres; the first is "".
    crossings : list of CrossingSight
        What lay across.
    """

    reasons: list[str] = field(default_factory=lambda: [""])
    crossings: list[CrossingSight] = field(default_factory=list)
    _blocks: list[Rows] = field(default_factory=list)
    _newest: Rows = field(default_factory=lambda: np.zeros(0, ROW))
    _free: int = 0

    def __len__(self) -> int:
        return sum(len(block) for block in self._blocks) + len(self._newest) - self._free

    @property
    def rows(self) -> Rows:
        """All rows, dtype `ROW`, shape (N,)."""
        if self._free < len(self._newest) or len(self._blocks) != 1:
            used = self._newest[: len(self._newest) - self._free]
            self._blocks = [np.concatenate((*self._blocks, used))]
            self._newest, self._free = np.zeros(0, ROW), 0
        return self._blocks[0]

    def append(self) -> Any:  # noqa: ANN401  A row of a structured array has no type.
        """Add an empty row, and return it to be filled."""
        if not self._free:
            if len(self._newest):
                self._blocks.append(self._newest)
            self._newest, self._free = np.full(GROWTH, EMPTY), GROWTH
        self._free -= 1
        return self._newest[len(self._newest) - self._free - 1]

    def reason_number(self, reason: str) -> int:
        """Return the number of a reason, which is remembered."""
        if reason not in self.reasons:
            self.reasons.append(reason)
        return self.reasons.index(reason)


@dataclass(slots=True, eq=False)
class Samples:
    """Readings with stamps that grow, in columns.

    Attributes
    ----------
    width : int
        Numbers of a reading.
    """

    width: int
    _stamps: list[int] = field(default_factory=list)
    _values: list[float] = field(default_factory=list)
    _blocks: list[tuple[npt.NDArray[np.int64], FloatArray]] = field(default_factory=list)

    def add(self, stamp: int, values: Sequence[float]) -> None:
        """Add a reading."""
        self._stamps.append(stamp)
        self._values.extend(values)
        if len(self._stamps) >= GROWTH:
            self._pack()

    def _pack(self) -> None:
        stamps = np.array(self._stamps, np.int64)
        self._blocks.append((stamps, np.array(self._values).reshape(-1, self.width)))
        self._stamps, self._values = [], []

    def arrays(self) -> tuple[IndexArray, FloatArray]:
        """Return stamps (N,) [ns] and readings (N, width)."""
        self._pack()
        stamps = np.concatenate([each for each, _ in self._blocks])
        return stamps, np.concatenate([values for _, values in self._blocks])
