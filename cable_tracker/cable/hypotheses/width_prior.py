"""The width prior: what is much narrower or wider than the cable was is something else.

A cable keeps its diameter, and a vehicle its altitude, more or less. So a rope beside a cable that
is overgrown just here is not taken for it, however clear its borders are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled_inside
from cable_tracker.particle_filter.student_t import relative_log_density

TAIL = 4.0
"""Degrees of freedom of the Student-t about the mean width."""

NARROWEST = 1e-3
"""Lower bound of a width whose logarithm is taken [px]."""

YOUNG_DOUBT = 3.0
"""Increase of the prior's relative scale at first, decaying with `width_time`."""


@dataclass(frozen=True, slots=True)
class WidthPrior:
    """A running mean of the width while the cable was tracked.

    Attributes
    ----------
    log_width : float
        Logarithm of the mean width [px].
    untracked_time : float
        Time since a cable was last tracked [s].
    tracked_time : float
        Total time for which a cable was tracked [s].
    """

    log_width: float
    untracked_time: float = 0.0
    tracked_time: float = 0.0

    def aged(self, dt: float) -> WidthPrior:
        """Return the prior `dt` seconds later."""
        return WidthPrior(self.log_width, self.untracked_time + dt, self.tracked_time)

    def spread(self, parameters: TrackerParameters) -> float:
        """Return the scale of the logarithm of widths.

        It grows while no cable is tracked. A width that was seen for a short time says little.
        """
        doubt = YOUNG_DOUBT * math.exp(-self.tracked_time / parameters.width_time)
        growth = self.untracked_time / parameters.width_memory
        return parameters.width_spread * (1.0 + doubt + growth)

    def deviation(self, width: float, parameters: TrackerParameters) -> float:
        """Return how far the logarithm of a width [px] is from the prior's, in its spreads."""
        return float(width_deviation(width, self.log_width, self.spread(parameters)))


@compiled_inside
def width_deviation(width: float, log_width: float, spread: float) -> float:
    """Return how far the logarithm of a width [px] is from `log_width`, in units of `spread`."""
    return (math.log(max(width, NARROWEST)) - log_width) / spread


@compiled_inside
def width_penalty(width: float, log_width: float, spread: float) -> float:
    """Return the logarithm of how well a width [px] fits, at most 0; 0 for an infinite spread."""
    if math.isinf(spread):
        return 0.0
    deviation = width_deviation(width, log_width, spread)
    return relative_log_density(deviation * deviation, TAIL, 1)


def updated_width_prior(
    before: WidthPrior | None, width: float, dt: float, parameters: TrackerParameters
) -> WidthPrior:
    """Return the prior after a frame in which a cable of a width [px] is tracked."""
    now = math.log(max(width, NARROWEST))
    if before is None:
        return WidthPrior(now)
    share = -math.expm1(-dt / parameters.width_time)
    tracked_time = before.tracked_time + dt
    log_width = before.log_width + share * (now - before.log_width)
    return WidthPrior(log_width, tracked_time=tracked_time)
