"""Re-detection: how soon a cable that came back into view was claimed again."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray
from cable_tracker.evaluation.sample_statistics import mean
from cable_tracker.evaluation.trace import Trace
from cable_tracker.stamps import NANOSECONDS

CLEARLY_BACK = 0.3
"""A cable that was out of view is back when so large a share of its borders can be seen."""

RETURN_SECONDS = 1.0
"""Time after the return within which a right claim counts as found again [s]."""


@dataclass(frozen=True, slots=True)
class CableReturn:
    """A cable that came back into view and stayed there for `RETURN_SECONDS` at least.

    Attributes
    ----------
    start : int
        Place in the run of the first frame with a visibility of `CLEARLY_BACK`.
    seconds : float
        From there to the first right claim, 0 if it was claimed before; NaN if there was none in
        `RETURN_SECONDS` [s].
    """

    start: int
    seconds: float


@dataclass(frozen=True, slots=True)
class ReturnStatistics:
    """How often a cable that came back into view was found again.

    Attributes
    ----------
    count : float
        Number of returns.
    found : float
        Share of them that were found again within `RETURN_SECONDS`, 0 to 1; NaN without a return.
    seconds : float
        Mean time until these were found [s]; NaN without one.
    """

    count: float
    found: float
    seconds: float


def cable_returns(trace: Trace) -> list[CableReturn]:
    """Return the returns of a cable that was in view before, in order.

    Left out are those after which the cable leaves, or the recording ends, before `RETURN_SECONDS`
    are over, because it might still have been found.
    """
    return [
        CableReturn(start + found.start, found.seconds)
        for start, stop in trace.recordings
        for found in _returns_of_recording(trace.part(start, stop))
    ]


def _returns_of_recording(trace: Trace) -> list[CableReturn]:
    """Return the returns in one recording, counted from its first frame."""
    right = trace.useful
    back = trace.visible & (trace.visibility >= CLEARLY_BACK)
    returns = []
    for start in _return_places(trace.hidden, back):
        # Whole nanoseconds, so that a frame after just one second is not lost to rounding.
        elapsed = trace.stamps[start:] - trace.stamps[start]
        count = int(np.searchsorted(elapsed, RETURN_SECONDS * NANOSECONDS, side="right"))
        over = elapsed[-1] >= RETURN_SECONDS * NANOSECONDS
        if not over or trace.hidden[start : start + count].any():
            continue
        found = np.flatnonzero(right[start : start + count])
        seconds = float(elapsed[found[0]] / NANOSECONDS) if len(found) else math.nan
        returns.append(CableReturn(start, seconds))
    return returns


def _return_places(hidden: BoolArray, back: BoolArray) -> list[int]:
    """Return where a cable is clearly back for the first time after it was hidden."""
    places, seen, away = [], False, False
    for place, (is_hidden, is_back) in enumerate(zip(hidden, back, strict=True)):
        away |= seen and bool(is_hidden)
        if is_back and away:
            places.append(place)
            away = False
        seen |= bool(is_back)
    return places


def return_statistics(trace: Trace) -> ReturnStatistics:
    """Summarise the returns of a cable in a run."""
    returns = cable_returns(trace)
    known = [each.seconds for each in returns if not math.isnan(each.seconds)]
    return ReturnStatistics(
        count=float(len(returns)),
        found=len(known) / len(returns) if returns else math.nan,
        seconds=mean(known),
    )
