"""Whether a cable is brighter than the bottom: summed over where it is not known."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled_inside, compiled_part
from cable_tracker.particle_filter.existence import probability_of

BRIGHT, DARK = 0, 1
"""Columns of what is said of cables that are brighter, and darker, than the bottom."""


class PolarityPrior(NamedTuple):
    """Logarithms of how likely a cable is to be brighter than the bottom, and darker."""

    log_bright: float
    log_dark: float


def polarity_prior(p_bright: float) -> PolarityPrior:
    """Return the prior for a probability of bright ones, above 0 and below 1."""
    return PolarityPrior(math.log(p_bright), math.log1p(-p_bright))


@compiled_inside
def marginal_log_ratio(polarity: PolarityPrior, bright: float, dark: float) -> float:
    """Return the log-likelihood ratio of a cable whose polarity is not known.

    `bright` and `dark` are those of a bright and of a dark cable.
    """
    first, second = polarity.log_bright + bright, polarity.log_dark + dark
    higher, less = max(first, second), min(first, second)
    return higher + math.log1p(math.exp(less - higher))


@compiled_part
def marginal_log_ratios(log_ratios: FloatArray, polarity: PolarityPrior) -> FloatArray:
    """Return the log-likelihood ratios (N,) of cables whose polarity is not known.

    `log_ratios` are those of bright and of dark cables, shape (N, 2).
    """
    result = np.empty(len(log_ratios))
    for row in range(len(log_ratios)):
        result[row] = marginal_log_ratio(polarity, log_ratios[row, BRIGHT], log_ratios[row, DARK])
    return result


@compiled_inside
def bright_share(polarity: PolarityPrior, bright: float, dark: float) -> float:
    """Return the posterior probability that a cable is a bright one; see `marginal_log_ratio`."""
    return probability_of(polarity.log_bright - polarity.log_dark + bright - dark)
