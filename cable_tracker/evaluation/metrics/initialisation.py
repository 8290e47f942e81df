"""Initialisation without knowledge of the cable: whether and how soon it was found."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from cable_tracker.evaluation.trace import Trace

START_FRAMES = 30
"""Number of frames that show the cable within which a right claim makes a start succeed."""


class StartOutcome(str, Enum):
    """How a start without knowledge of the cable went."""

    RIGHT = "right"
    """The cable was claimed, and rightly, within `START_FRAMES` frames."""

    WRONG = "wrong"
    """Start with claims in time, but only of something else: a wrong lock."""

    NONE = "none"
    """Start without a claim in time."""


@dataclass(frozen=True, slots=True)
class StartStatistics:
    """How a start at random went.

    Attributes
    ----------
    outcome : StartOutcome or None
        None if no frame shows a cable.
    frames_to_right : float
        Number of visible frames until the first right claim, from 1; NaN if there was none.
    visibility : float
        Mean share of the borders that can be seen over the frames that the start is judged by, the
        first `START_FRAMES` that show a cable, 0 to 1; NaN if none does.
    """

    outcome: StartOutcome | None
    frames_to_right: float
    visibility: float


def start_statistics(trace: Trace) -> StartStatistics:
    """Return the statistics of the first `START_FRAMES` frames that show a cable."""
    visible = np.flatnonzero(trace.visible)
    if not len(visible):
        return StartStatistics(None, math.nan, math.nan)
    claimed = trace.claimed[visible]
    found = np.flatnonzero(trace.useful[visible])
    to_right = float(found[0] + 1) if len(found) else math.nan
    if to_right <= START_FRAMES:
        outcome = StartOutcome.RIGHT
    elif claimed[:START_FRAMES].any():
        outcome = StartOutcome.WRONG
    else:
        outcome = StartOutcome.NONE
    visibility = float(trace.visibility[visible[:START_FRAMES]].mean())
    return StartStatistics(outcome, to_right, visibility)
