from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.weigh.presence import (
    HIGHEST,
    LOWEST,
    NEW_LOG_ODDS,
    SAME_HYPOTHESIS_RADII,
    PriorPresence,
    inherited_log_odds,
    is_same_hypothesis,
    updated_log_odds,
)
from cable_tracker.cable.hypotheses.weigh.score_likelihood import (
    MODEL,
    FrameScores,
    frame_log_likelihood_ratio,
)
from cable_tracker.particle_filter.existence import log_odds_of, probability_of

NEW = math.nan


def prior(survival: float, appearance: float = 0.0) -> PriorPresence:
    return PriorPresence(np.empty((0, 8)), np.empty(0), survival, appearance, 0.3)


FAINT = FrameScores(margin=12.0, score=12.0, clearness=0.5, shown=1.0, appearance=0.0)


@given(
    st.floats(LOWEST, HIGHEST),
    st.floats(-50, 50),
    st.floats(-50, 50),
    st.floats(0, 1),
    st.floats(0, 1),
)
def test_log_odds_stay_where_they_can_turn(before, margin, score, survival, appearance):
    scores = FAINT._replace(margin=margin, score=score)
    for inherited in (before, NEW):
        after = updated_log_odds(inherited, scores, prior(survival, appearance), MODEL)
        assert LOWEST <= after <= HIGHEST


def test_a_hypothesis_that_goes_on_gains_a_share_and_a_new_one_all():
    odds = frame_log_likelihood_ratio(FAINT, MODEL)
    assert updated_log_odds(NEW, FAINT, prior(1.0), MODEL) == pytest.approx(NEW_LOG_ODDS + odds)
    assert updated_log_odds(0.5, FAINT, prior(1.0), MODEL) == pytest.approx(0.5 + 0.3 * odds)
    vanishing, staying = (updated_log_odds(2.0, FAINT, prior(s), MODEL) for s in (0.1, 1.0))
    assert vanishing < staying


@given(st.floats(-9, 9))
def test_log_odds_and_probabilities_are_the_same(odds):
    assert log_odds_of(probability_of(odds)) == pytest.approx(odds, abs=1e-6)


def prior_of(expected: np.ndarray) -> PriorPresence:
    log_odds = np.arange(1.0, len(expected) + 1)
    return PriorPresence(expected, log_odds, 1.0, 0.0, 0.3)


def test_a_hypothesis_inherits_from_the_nearest_that_is_near_enough():
    expected = np.zeros((2, 8))
    expected[:, :4] = [[10.0, 0.1, 30.0, 0.0], [16.0, 0.1, 30.0, 0.0]]
    means = np.zeros((3, 8))
    # The last is the first, written the other way round.
    means[:, :4] = [[15.0, 0.1, 30.0, 0.0], [80.0, 0.1, 30.0, 0.0], [-10.0, 0.1 - np.pi, 30.0, 0.0]]
    found = [inherited_log_odds(prior_of(expected), mean, SAME_HYPOTHESIS_RADII) for mean in means]
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
