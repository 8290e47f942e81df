from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.presence import (
    HIGHEST,
    LEAST_LOG_ODDS,
    LOWEST,
    MODEL,
    NEAR,
    NEW_LOG_ODDS,
    PriorPresence,
    Standing,
    frame_log_odds,
    gain_over,
    goes_on,
    inherited_log_odds,
    thin_factor,
    updated_log_odds,
)
from cable_tracker.particle_filter.existence import log_odds_of, probability_of

NEW = math.nan


NOTHING = np.empty((0, 8))


def prior(
    survival: float, appearance: float = 0.0, expected: np.ndarray = NOTHING
) -> PriorPresence:
    return PriorPresence(expected, np.arange(1.0, len(expected) + 1), survival, appearance, 0.3)


FAINT = Standing(margin=12.0, standard_score=12.0, clearness=0.5, shown=1.0)


@given(
    st.builds(
        Standing,
        margin=st.floats(-1e3, 1e3),
        standard_score=st.floats(-1e3, 1e3),
        clearness=st.floats(-1e3, 1e3),
        shown=st.floats(0.0, 1.0),
    ),
    st.sampled_from(Standing._fields),
    st.floats(0.0, 1e3),
)
def test_to_stand_out_more_never_speaks_less_for_a_cable(standing, name, more):
    odds = frame_log_odds(standing)
    assert (
        odds <= frame_log_odds(standing._replace(**{name: getattr(standing, name) + more})) + 1e-9
    )
    assert LEAST_LOG_ODDS <= odds <= MODEL.largest_log_odds


def test_the_best_of_a_bare_bottom_speaks_against_a_cable_and_a_clear_cable_for_it():
    assert frame_log_odds(FAINT._replace(standard_score=5.0)) < 0.0
    assert frame_log_odds(FAINT._replace(standard_score=10.0)) > 0.0


def test_what_hardly_stands_above_strips_like_it_is_no_cable_however_high_its_score():
    assert (
        frame_log_odds(FAINT._replace(margin=MODEL.ordinary_margin - 4.0, standard_score=16.0))
        < 0.0
    )


def test_what_stands_far_above_strips_like_it_is_one_though_the_bottom_is_coarse():
    coarse = FAINT._replace(standard_score=6.0)
    assert frame_log_odds(coarse._replace(margin=MODEL.clear_margin + 8.0)) > 1.0
    assert frame_log_odds(coarse._replace(margin=MODEL.clear_margin)) < 0.0


def test_a_clear_strip_in_a_corner_is_a_cable_and_a_clear_edge_of_a_stone_is_not():
    low = Standing(
        margin=MODEL.ordinary_margin - 1.0,
        standard_score=6.0,
        clearness=MODEL.clearness + 0.4,
        shown=0.0,
    )
    assert frame_log_odds(low._replace(shown=MODEL.enough_shown)) > 3.0
    assert frame_log_odds(low._replace(shown=MODEL.least_shown)) < 0.0
    assert frame_log_odds(low._replace(shown=MODEL.enough_shown, clearness=MODEL.clearness)) < 0.0


@given(
    st.floats(LOWEST, HIGHEST),
    st.floats(-50, 50),
    st.floats(-50, 50),
    st.floats(0, 1),
    st.floats(0, 1),
)
def test_log_odds_stay_where_they_can_turn(before, level, score, survival, appearance):
    standing = FAINT._replace(margin=level, standard_score=score)
    for inherited in (before, NEW):
        after = updated_log_odds(inherited, standing, prior(survival, appearance))
        assert LOWEST <= after <= HIGHEST


def test_a_hypothesis_that_goes_on_gains_a_share_and_a_new_one_all():
    odds = frame_log_odds(FAINT)
    assert updated_log_odds(NEW, FAINT, prior(1.0)) == pytest.approx(NEW_LOG_ODDS + odds)
    assert updated_log_odds(0.5, FAINT, prior(1.0)) == pytest.approx(0.5 + 0.3 * odds)
    vanishing, staying = (updated_log_odds(2.0, FAINT, prior(s)) for s in (0.1, 1.0))
    assert vanishing < staying


@given(st.floats(-9, 9))
def test_log_odds_and_probabilities_are_the_same(odds):
    assert log_odds_of(probability_of(odds)) == pytest.approx(odds, abs=1e-6)


def test_a_hypothesis_inherits_from_the_nearest_that_is_near_enough():
    expected = np.zeros((2, 8))
    expected[:, :4] = [[10.0, 0.1, 30.0, 0.0], [16.0, 0.1, 30.0, 0.0]]
    means = np.zeros((3, 8))
    # The last is the first, written the other way round.
    means[:, :4] = [[15.0, 0.1, 30.0, 0.0], [80.0, 0.1, 30.0, 0.0], [-10.0, 0.1 - np.pi, 30.0, 0.0]]
    found = [inherited_log_odds(prior(1.0, 0.0, expected), mean, NEAR) for mean in means]
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
    assert goes_on(beside, expected, NEAR)
    assert not goes_on(elsewhere, expected, NEAR)


def test_thin_strips_count_less_but_something():
    factors = [thin_factor(width, 12.0) for width in (0.0, 3.0, 6.0, 12.0, 100.0)]
    assert factors == pytest.approx([0.5, 0.5, math.sqrt(0.5), 1.0, 1.0])


@given(gain=st.floats(0.0, 1.0), dt=st.floats(0.001, 1.0))
def test_evidence_of_frames_adds_up_over_time_at_any_rate(gain, dt):
    assert gain_over(gain, 0.04) == pytest.approx(gain)
    assert gain_over(gain, 0.0) == pytest.approx(gain)
    assert 1.0 - gain_over(gain, 2 * dt) == pytest.approx((1.0 - gain_over(gain, dt)) ** 2)
