from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.presence import (
    ENOUGH_SHOWN,
    HIGHEST,
    KNOWN_MODEL,
    LEAST_SHOWN,
    LOWEST,
    MODEL,
    NEW_LOG_ODDS,
    SAME_HYPOTHESIS_RADII,
    FrameScores,
    PriorPresence,
    ScoreModel,
    frame_log_likelihood_ratio,
    inherited_log_odds,
    is_same_hypothesis,
    least_log_ratio,
    thin_factor,
    trusted_appearance,
    updated_log_odds,
)
from cable_tracker.particle_filter.existence import log_odds_of, probability_of

NEW = math.nan

FAINT = FrameScores(margin=12.0, score=12.0, clearness=0.5, shown=1.0, appearance=0.0)


def prior(survival: float, appearance: float = 0.0) -> PriorPresence:
    return PriorPresence(np.empty((0, 8)), np.empty(0), survival, appearance, 0.3)


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


def ratio_of(scores: FrameScores, model: ScoreModel = MODEL) -> float:
    return frame_log_likelihood_ratio(scores, model)


@given(
    st.builds(
        FrameScores,
        margin=st.floats(-1e3, 1e3),
        score=st.floats(-1e3, 1e3),
        clearness=st.floats(-1e3, 1e3),
        shown=st.floats(0.0, 1.0),
        appearance=st.floats(-1e3, 1e3),
    ),
    st.sampled_from(FrameScores._fields),
    st.floats(0.0, 1e3),
)
def test_to_stand_out_more_never_speaks_less_for_a_cable(scores, name, more):
    ratio = ratio_of(scores)
    assert ratio <= ratio_of(scores._replace(**{name: getattr(scores, name) + more})) + 1e-9
    assert least_log_ratio(MODEL) <= ratio <= MODEL.largest_log_ratio


def test_the_best_of_a_bare_bottom_speaks_against_a_cable_and_a_clear_cable_for_it():
    assert ratio_of(FAINT._replace(score=5.0)) < 0.0
    assert ratio_of(FAINT._replace(score=10.0)) > 0.0


def test_a_small_margin_over_similar_strips_speaks_against_a_cable_whatever_its_score():
    assert ratio_of(FAINT._replace(margin=MODEL.ordinary_margin - 4.0, score=16.0)) < 0.0


def test_a_large_margin_over_similar_strips_speaks_for_a_cable_on_a_coarse_bottom():
    coarse = FAINT._replace(score=6.0)
    assert ratio_of(coarse._replace(margin=MODEL.clear_margin + 8.0)) > 1.0
    assert ratio_of(coarse._replace(margin=MODEL.clear_margin)) < 0.0


def test_a_clear_strip_in_a_corner_is_a_cable_and_a_clear_edge_of_a_stone_is_not():
    low = FrameScores(
        margin=MODEL.ordinary_margin - 1.0,
        score=6.0,
        clearness=MODEL.ordinary_clearness + 0.4,
        shown=0.0,
        appearance=0.0,
    )
    assert ratio_of(low._replace(shown=ENOUGH_SHOWN)) > 3.0
    assert ratio_of(low._replace(shown=LEAST_SHOWN)) < 0.0
    assert ratio_of(low._replace(shown=ENOUGH_SHOWN, clearness=MODEL.ordinary_clearness)) < 0.0


def test_a_likely_appearance_speaks_for_a_cable_with_faint_borders():
    faint = FAINT._replace(margin=3.0, score=4.0)
    assert ratio_of(faint) < 0.0 < ratio_of(faint._replace(appearance=3.0))
    assert ratio_of(FAINT._replace(appearance=-3.0)) < 0.0


def test_a_known_cable_need_not_be_the_best_of_the_frame():
    ordinary = FrameScores(margin=4.0, score=6.0, clearness=0.2, shown=1.0, appearance=0.0)
    assert ratio_of(ordinary) < 0.0
    assert ratio_of(ordinary, KNOWN_MODEL) > 0.0


def test_a_known_cable_that_is_gone_is_given_up_sooner_than_one_among_many():
    bottom = FrameScores(margin=-2.0, score=1.0, clearness=-0.1, shown=1.0, appearance=-3.0)
    assert ratio_of(bottom, KNOWN_MODEL) < ratio_of(bottom) < 0.0


def test_looks_say_nothing_against_borders_that_no_bottom_has():
    odd = FAINT._replace(appearance=-6.0)
    clearest = odd._replace(clearness=MODEL.ordinary_clearness + MODEL.clearness_range)
    assert ratio_of(odd._replace(clearness=MODEL.ordinary_clearness)) < 0.0
    assert ratio_of(clearest) == ratio_of(clearest._replace(appearance=0.0)) > 3.0
    assert ratio_of(clearest._replace(shown=0.0)) < 0.0


def test_thin_strips_count_less_but_something():
    factors = [thin_factor(width, 12.0) for width in (0.0, 3.0, 6.0, 12.0, 100.0)]
    assert factors == pytest.approx([0.5, 0.5, math.sqrt(0.5), 1.0, 1.0])


@given(st.floats(0.1, 500.0), st.floats(-20.0, 20.0))
def test_looks_speak_for_wide_strips_alone_and_against_all(width, appearance):
    trusted = trusted_appearance(appearance, width, 12.0)
    assert min(appearance, 0.0) - 1e-9 <= trusted <= max(appearance, 0.0) + 1e-9
    if width >= 24.0 or appearance <= 0.0:
        assert trusted == pytest.approx(appearance)
    elif width <= 16.0:
        assert trusted == 0.0
