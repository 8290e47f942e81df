"""Medians and quartiles of times, percentiles of latencies, straight lines through costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class Quartiles:
    """The middle half of some numbers.

    Attributes
    ----------
    low, median, high : float
        Quantiles 1/4, 1/2 and 3/4.
    count : int
        Number of values.
    """

    low: float
    median: float
    high: float
    count: int

    @classmethod
    def of(cls, values: Sequence[float] | FloatArray) -> Quartiles:
        """Return the quartiles of at least one number."""
        low, median, high = np.quantile(np.asarray(values, np.float64), (0.25, 0.5, 0.75))
        return cls(float(low), float(median), float(high), len(values))


@dataclass(frozen=True, slots=True)
class Percentiles:
    """The middle and the tail of some latencies.

    Attributes
    ----------
    median, p95, p99 : float
        Quantiles 0.5, 0.95 and 0.99.
    count : int
        Number of latencies.
    """

    median: float
    p95: float
    p99: float
    count: int

    @classmethod
    def of(cls, values: Sequence[float] | FloatArray) -> Percentiles:
        """Return the percentiles of at least one number."""
        median, p95, p99 = np.quantile(np.asarray(values, np.float64), (0.5, 0.95, 0.99))
        return cls(float(median), float(p95), float(p99), len(values))


def fit_line(amounts: Sequence[float], costs: Sequence[float]) -> tuple[float, float]:
    """Fit cost = base + slope * amount, so that relative residuals are smallest.

    Parameters
    ----------
    amounts : sequence of float
        At least two different ones.
    costs : sequence of float
        As many, above zero. A residual of a tenth counts alike for small and for large ones.

    Returns
    -------
    base, slope : float
        Cost of nothing, and of one more.
    """
    slope, base = np.polyfit(amounts, costs, 1, w=1.0 / np.asarray(costs, np.float64))
    return float(base), float(slope)
