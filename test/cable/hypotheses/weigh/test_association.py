from __future__ import annotations

import math

import numpy as np

from cable_tracker.cable.hypotheses.weigh.association import (
    SAME_HYPOTHESIS_RADII,
    inherited_log_odds,
    is_same_hypothesis,
)
from cable_tracker.cable.hypotheses.weigh.presence import PriorPresence


def prior(expected: np.ndarray) -> PriorPresence:
    log_odds = np.arange(1.0, len(expected) + 1)
    return PriorPresence(expected, log_odds, 1.0, 0.0, 0.3)


def test_a_hypothesis_inherits_from_the_nearest_that_is_near_enough():
    expected = np.zeros((2, 8))
    expected[:, :4] = [[10.0, 0.1, 30.0, 0.0], [16.0, 0.1, 30.0, 0.0]]
    means = np.zeros((3, 8))
    # The last is the first, written the other way round.
    means[:, :4] = [[15.0, 0.1, 30.0, 0.0], [80.0, 0.1, 30.0, 0.0], [-10.0, 0.1 - np.pi, 30.0, 0.0]]
    found = [inherited_log_odds(prior(expected), mean, SAME_HYPOTHESIS_RADII) for mean in means]
    assert found[0] == 2.0
    assert math.isnan(found[1])
    assert found[2] == 1.0


def test_a_leader_goes_on_near_where_it_is_expected():
    expected, beside, elsewhere = np.zeros((3, 8))
    expected[:4], beside[:4], elsewhere[:4] = (
        [0.0, 0.0, 30.0, 0.0],
        [10.0, 0.1, 30.0, 0.0],
        [60.0, 0.0, 30.0, 0.0],
    )
    assert is_same_hypothesis(beside, expected, SAME_HYPOTHESIS_RADII)
    assert not is_same_hypothesis(elsewhere, expected, SAME_HYPOTHESIS_RADII)
