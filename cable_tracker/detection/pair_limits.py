"""Which pairs of lines a detector takes for the borders of a cable."""

from __future__ import annotations

import math
from typing import NamedTuple

from cable_tracker.cable.parameters.parameters import TrackerParameters


class PairLimits(NamedTuple):
    """Smallest and largest cable that a detector reports.

    Attributes
    ----------
    narrowest, widest : float
        Smallest and largest w [px at the reference width].
    most_skew : float
        Largest |beta| [rad].
    """

    narrowest: float
    widest: float
    most_skew: float


def pair_limits(parameters: TrackerParameters) -> PairLimits:
    """Return limits that cover the cables that a tracker can follow."""
    return PairLimits(
        narrowest=parameters.width_minimum,
        widest=parameters.width_maximum,
        most_skew=math.radians(parameters.skew_limit),
    )


DEFAULT_LIMITS = pair_limits(TrackerParameters())
"""Limits of the preset `default`."""
