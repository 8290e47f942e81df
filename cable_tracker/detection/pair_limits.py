"""Which pairs of lines a detector takes for the borders of a cable."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cable_tracker.cable.parameters.parameters import TrackerParameters


@dataclass(frozen=True, slots=True)
class PairLimits:
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

    def scaled(self, factor: float) -> PairLimits:
        """Return the limits with widths multiplied by a factor."""
        return PairLimits(self.narrowest * factor, self.widest * factor, self.most_skew)


def pair_limits(parameters: TrackerParameters) -> PairLimits:
    """Return limits that cover the cables a tracker can follow and those it starts from."""
    skews = (
        parameters.skew_limit,
        abs(parameters.initial_skew_minimum),
        abs(parameters.initial_skew_maximum),
    )
    return PairLimits(
        narrowest=min(parameters.width_minimum, parameters.initial_width_minimum),
        widest=max(parameters.width_maximum, parameters.initial_width_maximum),
        most_skew=math.radians(max(skews)),
    )


DEFAULT_LIMITS = pair_limits(TrackerParameters())
"""Limits of the preset `default`."""
