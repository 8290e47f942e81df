"""Figures of samples that may be empty: NaN then, without a warning."""

from __future__ import annotations

import math
from collections.abc import Sequence
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


def root_mean_square(values: FloatArray) -> float:
    """Return the root of the mean square of a sample, shape (N,)."""
    return math.sqrt(mean(values**2)) if len(values) else math.nan


def percentile_of_size(values: FloatArray, percent: float) -> float:
    """Return a percentile, 0 to 100, of the absolute values of a sample, shape (N,)."""
    return float(np.percentile(np.abs(values), percent)) if len(values) else math.nan
