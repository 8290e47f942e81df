from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.presence import (
    HIDDEN_SHARE,
    HIGHEST,
    LARGEST_ODDS,
    LOWEST,
    NEW_ODDS,
    NULL_TIME,
    SMALLEST_SPREAD,
    NullLevels,
    frame_odds,
    inherited_odds,
    log_odds_of,
    null_moments,
    probability_of,
    thin_factor,
    updated_odds,
)
from cable_tracker.cable.measure.border_points import frame_scan
from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.parameters.parameters import TrackerParameters

NEW = math.nan


@given(st.floats(-1e3, 1e3), st.floats(0.0, 1e3))
def test_a_higher_score_never_speaks_less_for_a_cable(score, more):
    assert frame_odds(score) <= frame_odds(score + more) + 1e-9
    assert math.log(HIDDEN_SHARE) - 1e-9 <= frame_odds(score) <= LARGEST_ODDS


def test_the_best_of_a_bare_bottom_speaks_against_a_cable_and_a_clear_cable_for_it():
    assert frame_odds(5.0) < 0.0 < frame_odds(10.0)


@given(st.floats(LOWEST, HIGHEST), st.floats(-50, 50), st.floats(0, 1), st.floats(0, 1))
def test_log_odds_stay_where_they_can_turn(before, score, survival, appearance):
    for inherited in (before, NEW):
        after = updated_odds(inherited, score, survival, appearance, 0.3)
        assert LOWEST <= after <= HIGHEST


def test_a_hypothesis_that_goes_on_gains_a_share_and_a_new_one_all():
    odds = frame_odds(12.0)
    assert updated_odds(NEW, 12.0, 1.0, 0.0, 0.3) == pytest.approx(NEW_ODDS + odds)
    assert updated_odds(0.5, 12.0, 1.0, 0.0, 0.3) == pytest.approx(0.5 + 0.3 * odds)
    assert updated_odds(2.0, 12.0, 0.1, 0.0, 0.3) < updated_odds(2.0, 12.0, 1.0, 0.0, 0.3)


@given(st.floats(-9, 9))
def test_log_odds_and_probabilities_are_the_same(odds):
    assert log_odds_of(probability_of(odds)) == pytest.approx(odds, abs=1e-6)


def test_a_hypothesis_inherits_from_the_nearest_that_is_near_enough():
    expected = np.zeros((2, 8))
    expected[:, :4] = [[10.0, 0.1, 30.0, 0.0], [16.0, 0.1, 30.0, 0.0]]
    means = np.zeros((3, 8))
    # The last is the first, written the other way round.
    means[:, :4] = [[15.0, 0.1, 30.0, 0.0], [80.0, 0.1, 30.0, 0.0], [-10.0, 0.1 - np.pi, 30.0, 0.0]]
    found = inherited_odds(expected, np.array([1.0, 2.0]), means, 320.0)
    assert found[0] == 2.0
    assert math.isnan(found[1])
    assert found[2] == 1.0


def test_the_null_is_averaged_over_time_and_its_spread_never_nothing():
    first = NullLevels().updated(-3.0, 13.0, 0.04)
    assert (first.mean, first.square, first.spread) == (-3.0, 13.0, 2.0)
    later = first.updated(-1.0, 13.0, NULL_TIME)
    assert later.mean == pytest.approx(-3.0 + 2.0 * (1.0 - math.exp(-1.0)))
    assert NullLevels(2.0, 4.0, True).spread == SMALLEST_SPREAD


def test_thin_strips_count_less_but_something():
    factors = [thin_factor(width, 12.0) for width in (0.0, 3.0, 6.0, 12.0, 100.0)]
    assert factors == pytest.approx([0.5, 0.5, math.sqrt(0.5), 1.0, 1.0])


def test_strips_that_share_a_border_with_the_leader_are_not_of_the_null(rng):
    picture = rng.normal(100.0, 10.0, (120, 160)).astype(np.float32)
    image = make_working_image(picture, 320)
    model = BorderLikelihoodRatio(TrackerParameters())
    strips = np.zeros((4, 8))
    strips[:, 0] = [0.0, 30.0, -60.0, 40.0]
    strips[:, 2] = [20.0, 40.0, 10.0, 30.0]
    strips[3, 3] = 0.5  # Its borders cross in view.
    leader = np.zeros(8)
    leader[2] = 20.0
    used, mean, square = null_moments(
        strips, frame_scan(image), model.model_for(image), 0.5, leader, (160.0, 120.0)
    )
    alone = model.log_likelihoods(strips[2:3], image)[0]
    assert used == 1
    assert mean == pytest.approx(alone)
    assert square == pytest.approx(alone**2)
