"""The table of estimates of a whole recording: `estimates.csv`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from cable_tracker.cable.model.state import STATE_SIZE, STATE_SYMBOLS, CableState
from cable_tracker.sequences.tables.csv_tables import write_csv
from cable_tracker.stamps import NANOSECONDS

HEADER = (
    "frame", "stamp", "status", *STATE_SYMBOLS,
    "sigma_d", "sigma_alpha", "sigma_w", "sigma_beta",
    "n_eff", "presence", "evidence", "hypotheses", "ms",
    "offset", "heading", "sigma_offset", "sigma_heading", "no_metres", "event",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class RowMetres:
    """The cable beside the vehicle, in the level frame of `metric.frames`.

    Attributes
    ----------
    offset : float
        y of the cable at x = 0, positive to the left [m].
    heading : float
        Direction of the cable from the vehicle's, positive to the left [rad].
    sigma_offset, sigma_heading : float
        Their standard deviations [m, rad].
    """

    offset: float
    heading: float
    sigma_offset: float
    sigma_heading: float


@dataclass(frozen=True, slots=True)
class EstimateRow:
    """One frame of a tracked recording.

    Attributes
    ----------
    frame : int
        Number of the frame in the recording.
    stamp : int
        Time of the frame [ns].
    status : str
        TRACKING, LOST, INITIALISING, or REFUSED for a frame that could not be used.
    state : CableState or None
        The estimate [px, rad, per second]; None where no cable is claimed.
    sigma : (float, float, float, float) or None
        Standard deviations of d, alpha, w, beta [px, rad]; None where no cable is claimed.
    n_eff : float or None
        Effective sample size; None for a refused frame.
    presence : float or None
        Probability that a cable is in view; None for a refused frame, and where the filter has no
        notion of it.
    evidence : float or None
        Evidence for the cable in the image; None for a refused frame.
    hypotheses : int or None
        In how many places the cable may be; None for a refused frame.
    ms : float or None
        Time the tracker took for the frame [ms]; None if it was not measured.
    metres : RowMetres or None
        The cable beside the vehicle; None where it is not known.
    no_metres : str
        Reason why there are no metres; empty otherwise, and for a refused frame.
    event : str
        Why the frame was refused, or why tracking started anew with it; empty otherwise.
    """

    frame: int
    stamp: int
    status: str
    state: CableState | None = None
    sigma: tuple[float, float, float, float] | None = None
    n_eff: float | None = None
    presence: float | None = None
    evidence: float | None = None
    hypotheses: int | None = None
    ms: float | None = None
    metres: RowMetres | None = None
    no_metres: str = ""
    event: str = ""


def format_stamp(stamp: int) -> str:
    """Write nanoseconds as seconds with all nine decimals, exactly."""
    sign = "-" if stamp < 0 else ""
    return f"{sign}{abs(stamp) // NANOSECONDS}.{abs(stamp) % NANOSECONDS:09d}"


def _format_number(value: float | None) -> str:
    return "" if value is None else repr(value)


def _format_row(row: EstimateRow) -> list[str]:
    state: Sequence[float | None] = (None,) * STATE_SIZE
    if row.state is not None:
        state = tuple(float(value) for value in row.state.to_array())
    sigma: Sequence[float | None] = row.sigma if row.sigma is not None else (None,) * 4
    ms = "" if row.ms is None else f"{row.ms:.3f}"
    belief = (row.n_eff, row.presence, row.evidence, row.hypotheses)
    metres: Sequence[float | None] = (None,) * 4
    if row.metres is not None:
        known = row.metres
        metres = (known.offset, known.heading, known.sigma_offset, known.sigma_heading)
    return [
        str(row.frame), format_stamp(row.stamp), row.status,
        *(_format_number(value) for value in (*state, *sigma, *belief)), ms,
        *(_format_number(value) for value in metres), row.no_metres, row.event,
    ]  # fmt: skip


def write_estimates(path: Path, rows: Iterable[EstimateRow]) -> None:
    """Write the table; numbers read back are equal to the last bit (`ms`: to the microsecond)."""
    write_csv(path, HEADER, map(_format_row, rows))
