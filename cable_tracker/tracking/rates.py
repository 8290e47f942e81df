"""Rates and factors per frame, turned into what they come to over a time."""

from __future__ import annotations

import math

from cable_tracker.compilation import compiled_inside
from cable_tracker.tracking.parameter_table import REFERENCE_RATE


@compiled_inside
def over_time(factor: float, dt: float) -> float:
    """Return the factor over `dt` seconds for a factor per frame at 25 frames per second."""
    return float(factor ** (dt * REFERENCE_RATE))


def share_over_time(share: float, dt: float) -> float:
    """Return the share of the way over `dt` seconds for a share per frame at 25 frames per second.

    At that rate it is the share itself, bit for bit.
    """
    frames = dt * REFERENCE_RATE
    return share if frames == 1.0 else float(1.0 - (1.0 - share) ** frames)


def event_probability(rate: float, dt: float) -> float:
    """Return the probability of at least one event within `dt` seconds, for a rate [1/s]."""
    return -math.expm1(-rate * dt)
