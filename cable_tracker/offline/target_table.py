"""The tables of a followed target: a row for each frame, in pixels and in metres."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cable_tracker.metric.messages import TARGET_METRES_KEYS, WHY_NOT_KEY
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.tables.estimates import format_stamp
from cable_tracker.target.model.estimate import Box, TargetEstimate
from cable_tracker.target.model.state import LOG_SCALE

HEADER = (
    "frame", "stamp", "status", "x", "y", "scale", "angle", "v_x", "v_y", "sigma_x", "sigma_y",
    "box_x0", "box_y0", "box_x1", "box_y1", "area", "presence", "n_eff", "ms", "event",
)  # fmt: skip

METRES_HEADER = ("frame", "stamp", *TARGET_METRES_KEYS)

CLAIM_SIZE = 13
"""Columns of the table from `x` to `area`."""


@dataclass(frozen=True, slots=True)
class TargetClaim:
    """A target that is claimed in one frame.

    Attributes
    ----------
    state : tuple of float
        x, y, scale, angle, v_x, v_y, from the image centre, y up [px, rad, per second].
    sigma : tuple of float
        Standard deviations of x and y [px].
    box : Box
        Around the contour [px].
    area : float
        Area of the contour [px²].
    """

    state: tuple[float, ...]
    sigma: tuple[float, float]
    box: Box
    area: float

    def cells(self) -> list[str]:
        """Return columns `x` to `area` of the table."""
        return [repr(x) for x in (*self.state, *self.sigma, *self.box, self.area)]


@dataclass(frozen=True, slots=True)
class TargetRow:
    """One frame of a followed target.

    Attributes
    ----------
    frame, stamp : int
        Number, and time [ns].
    status : str
        TRACKING, LOST, INITIALISING, or REFUSED for a frame that could not be used.
    claim : TargetClaim or None
        None without a claim.
    presence, n_eff : float or None
        None for a refused frame.
    ms : float or None
        Time the tracker took [ms].
    event : str
        Event of the frame that a user should know of: why it was refused, or why tracking started
        anew.
    """

    frame: int
    stamp: int
    status: str
    claim: TargetClaim | None = None
    presence: float | None = None
    n_eff: float | None = None
    ms: float | None = None
    event: str = ""

    def cells(self) -> list[str]:
        """Return the fields of the table; those of the state are empty without a claim."""
        cells = [str(self.frame), format_stamp(self.stamp), self.status]
        cells += [""] * CLAIM_SIZE if self.claim is None else self.claim.cells()
        cells += ["" if x is None else repr(x) for x in (self.presence, self.n_eff)]
        return [*cells, "" if self.ms is None else f"{self.ms:.3f}", self.event]


def row_of(frame: Frame, estimate: TargetEstimate, ms: float | None) -> TargetRow:
    """Return the row of the table for a frame that was used."""
    claim = None
    if estimate.is_claimed:
        assert estimate.box is not None
        state = estimate.state.copy()
        state[LOG_SCALE] = estimate.scale
        sigma_x, sigma_y = (float(value) for value in estimate.standard_deviations()[:2])
        left, top, right, bottom = (float(side) for side in estimate.box)
        box = (left, top, right, bottom)
        sigma = (sigma_x, sigma_y)
        claim = TargetClaim(tuple(state.tolist()), sigma, box, float(estimate.area))
    return TargetRow(
        frame.index, frame.stamp, estimate.status.value, claim, float(estimate.presence),
        float(estimate.effective_sample_size), ms, estimate.event,
    )  # fmt: skip


def metres_row(frame: Frame, facts: Mapping[str, str]) -> tuple[str, ...]:
    """Return a frame's row of the table in metres; empty cells for unknown values.

    Parameters
    ----------
    facts : mapping
        Values of the report in metres, see `target_facts`.
    """
    cells = (facts.get(key, "") for key in TARGET_METRES_KEYS)
    return (str(frame.index), format_stamp(frame.stamp), *cells)


def refused_metres_row(frame: Frame, reason: str) -> tuple[str, ...]:
    """Return the row of the table in metres for a frame that was refused for a reason."""
    return metres_row(frame, {WHY_NOT_KEY: f"the frame was refused: {reason}"})
