"""A number over several runs, with its spread."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


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
