"""The rounds of a frame: how much of the likelihood and how many particles each of them gets."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import IndexArray
from cable_tracker.cable.parameters.parameters import TrackerParameters

FIRST_POWER = 0.3
"""Power of the likelihood in the first round, also where it is the only one; in the last of several
it is 1. This annealing keeps a narrow peak from being missed."""

WIDENINGS = (1.5, 1.2)
"""Factor on the covariance of the particles that a round draws about: first round, later ones."""


def annealing_power(number: int, rounds: int) -> float:
    """Return the power of the likelihood in a round: `FIRST_POWER` in the first, rising to 1."""
    if rounds == 1:
        return FIRST_POWER
    return float(FIRST_POWER ** (1.0 - number / (rounds - 1)))


def widening_in(number: int) -> float:
    """Return the factor on the covariance of the particles that a round draws about."""
    return WIDENINGS[min(number, len(WIDENINGS) - 1)]


def round_weights(rounds: int) -> list[float]:
    """Return the share of each round; the last, which counts most, has more than the others."""
    if rounds == 0:
        return []
    parts = [1.0] * (rounds - 1) + [1.5]
    return [part / sum(parts) for part in parts]


def refined_counts(parameters: TrackerParameters) -> IndexArray:
    """Return how many particles each round draws, shape (R,)."""
    refined = parameters.refinement_share * parameters.particle_count
    shares = round_weights(parameters.refinement_rounds)
    return np.array([int(refined * share) for share in shares], np.int64)
