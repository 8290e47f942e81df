"""Figures of samples, and spreads over runs, that may be empty: NaN then, without a warning."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray

Sample: TypeAlias = FloatArray | BoolArray | Sequence[float] | Sequence[bool]


def mean(values: Sample) -> float:
    """Return the mean of a sample; of flags, the share that holds."""
    return float(np.mean(values)) if len(values) else math.nan


def median(values: Sample) -> float:
    """Return the median of a sample."""
    return float(np.median(values)) if len(values) else math.nan


def percentage(part: float, whole: float) -> float:
    """Return the share of a part in the whole [%]."""
    return 100.0 * part / whole if whole else math.nan


def percentages(parts: FloatArray, wholes: FloatArray) -> FloatArray:
    """Return the shares of parts in wholes [%], counts of one shape."""
    return np.where(wholes > 0.0, 100.0 * parts / np.maximum(wholes, 1.0), math.nan)


def root_mean_square(values: FloatArray) -> float:
    """Return the root of the mean square of a sample, shape (N,)."""
    return math.sqrt(mean(values**2)) if len(values) else math.nan


def percentile_of_size(values: FloatArray, percent: float) -> float:
    """Return a percentile, 0 to 100, of the absolute values of a sample, shape (N,)."""
    return float(np.percentile(np.abs(values), percent)) if len(values) else math.nan


@dataclass(frozen=True, slots=True)
class Spread:
    """A number over several runs.

    Attributes
    ----------
    count : int
        Runs in which it is defined; the others are left out.
    mean, median, minimum, maximum : float
        NaN over no runs.
    standard_error : float
        Standard error of the mean; NaN below two runs.
    """

    count: int
    mean: float
    median: float
    minimum: float
    maximum: float
    standard_error: float


def spread_of(values: Iterable[float]) -> Spread:
    """Summarise a number over runs; NaN is left out."""
    known = np.array([value for value in values if not math.isnan(value)])
    if not len(known):
        return Spread(0, math.nan, math.nan, math.nan, math.nan, math.nan)
    finite = len(known) > 1 and bool(np.isfinite(known).all())
    error = float(known.std(ddof=1) / math.sqrt(len(known))) if finite else math.nan
    return Spread(
        count=len(known),
        mean=float(known.mean()),
        median=float(np.median(known)),
        minimum=float(known.min()),
        maximum=float(known.max()),
        standard_error=error,
    )
