"""See `cable_tracker.particle_filter.student_t`."""

from __future__ import annotations

import math

from cable_tracker.compilation import compiled, compiled_inside


@compiled_inside
def tail(squared_distance: float, degrees_of_freedom: float, dimensions: int) -> float:
    """Return the density over its peak at a squared Mahalanobis distance."""
    if math.isinf(degrees_of_freedom):
        return math.exp(-0.5 * squared_distance)
    if degrees_of_freedom == 4.0 and dimensions == 4:
        base = 1.0 + 0.25 * squared_distance
        square = base * base
        return 1.0 / (square * square)
    exponent = -0.5 * (degrees_of_freedom + dimensions)
    return math.exp(exponent * math.log1p(squared_distance / degrees_of_freedom))


@compiled
def peak_density(degrees_of_freedom: float, dimensions: int) -> float:
    """Return the density at the location for a unit scale."""
    if math.isinf(degrees_of_freedom):
        return math.pow(2.0 * math.pi, -0.5 * dimensions)
    log_peak = (
        math.lgamma((degrees_of_freedom + dimensions) / 2)
        - math.lgamma(degrees_of_freedom / 2)
        - 0.5 * dimensions * math.log(degrees_of_freedom * math.pi)
    )
    return math.exp(log_peak)
