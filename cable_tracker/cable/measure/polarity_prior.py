"""Whether a cable is brighter than the bottom: summed over where it is not known."""

from __future__ import annotations

import math
from typing import NamedTuple

from cable_tracker.compilation import compiled_inside
from cable_tracker.particle_filter.existence import probability_of


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


@compiled_inside
def bright_share(polarity: PolarityPrior, bright: float, dark: float) -> float:
    """Return the posterior probability that a cable is a bright one; see `marginal_log_ratio`."""
    return probability_of(polarity.log_bright - polarity.log_dark + bright - dark)
