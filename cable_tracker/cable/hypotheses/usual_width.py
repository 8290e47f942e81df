"""The usual width of the cable: what is much narrower or wider is something else.

A cable keeps its diameter, and a vehicle its altitude, more or less. So a rope beside a cable that
is overgrown just here is not taken for it, however clear its borders are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import StateColumn
from cable_tracker.cable.parameters.parameters import TrackerParameters

TAIL = 4.0
"""Degrees of freedom of the Student-t about the usual width."""


@dataclass(frozen=True, slots=True)
class UsualWidth:
    """A running mean of the width while the cable was tracked.

    Attributes
    ----------
    log_width : float
        Logarithm of the mean width [px].
    unseen : float
        How long no cable was tracked [s].
    """

    log_width: float
    unseen: float = 0.0

    def aged(self, dt: float) -> UsualWidth:
        """Return what is known `dt` seconds later."""
        return replace(self, unseen=self.unseen + dt)

    def spread(self, parameters: TrackerParameters) -> float:
        """Return the scale of the logarithm of widths that are as good as usual."""
        return parameters.width_spread * (1.0 + self.unseen / parameters.memory_time)

    def log_factors(self, states: FloatArray, parameters: TrackerParameters) -> FloatArray:
        """Return the logarithm of how well each width fits, shape (N,); 0 for the usual one.

        The longer no cable was tracked, the less it says.
        """
        spread = self.spread(parameters)
        widths = np.maximum(states[:, StateColumn.WIDTH], 1e-3)
        deviations = (np.log(widths) - self.log_width) / spread
        factors: FloatArray = -0.5 * (TAIL + 1.0) * np.log1p(deviations**2 / TAIL)
        return factors


def width_seen(
    before: UsualWidth | None, width: float, dt: float, parameters: TrackerParameters
) -> UsualWidth:
    """Return what is known after a frame in which a cable of a width [px] is tracked."""
    now = math.log(max(width, 1e-3))
    if before is None:
        return UsualWidth(now)
    share = -math.expm1(-dt / parameters.width_time)
    return UsualWidth(before.log_width + share * (now - before.log_width))
