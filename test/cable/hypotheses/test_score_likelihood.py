from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.score_likelihood import (
    LEAST_LOG_RATIO,
    MODEL,
    FrameScores,
    frame_log_likelihood_ratio,
)

FAINT = FrameScores(margin=12.0, score=12.0, clearness=0.5, shown=1.0)


@given(
    st.builds(
        FrameScores,
        margin=st.floats(-1e3, 1e3),
        score=st.floats(-1e3, 1e3),
        clearness=st.floats(-1e3, 1e3),
        shown=st.floats(0.0, 1.0),
    ),
    st.sampled_from(FrameScores._fields),
    st.floats(0.0, 1e3),
)
def test_to_stand_out_more_never_speaks_less_for_a_cable(scores, name, more):
    ratio = frame_log_likelihood_ratio(scores)
    assert (
        ratio
        <= frame_log_likelihood_ratio(scores._replace(**{name: getattr(scores, name) + more}))
        + 1e-9
    )
    assert LEAST_LOG_RATIO <= ratio <= MODEL.largest_log_ratio


def test_the_best_of_a_bare_bottom_speaks_against_a_cable_and_a_clear_cable_for_it():
    assert frame_log_likelihood_ratio(FAINT._replace(score=5.0)) < 0.0
    assert frame_log_likelihood_ratio(FAINT._replace(score=10.0)) > 0.0


def test_what_hardly_stands_above_strips_like_it_is_no_cable_however_high_its_score():
    assert (
        frame_log_likelihood_ratio(FAINT._replace(margin=MODEL.ordinary_margin - 4.0, score=16.0))
        < 0.0
    )


def test_what_stands_far_above_strips_like_it_is_one_though_the_bottom_is_coarse():
    coarse = FAINT._replace(score=6.0)
    assert frame_log_likelihood_ratio(coarse._replace(margin=MODEL.clear_margin + 8.0)) > 1.0
    assert frame_log_likelihood_ratio(coarse._replace(margin=MODEL.clear_margin)) < 0.0


def test_a_clear_strip_in_a_corner_is_a_cable_and_a_clear_edge_of_a_stone_is_not():
    low = FrameScores(
        margin=MODEL.ordinary_margin - 1.0,
        score=6.0,
        clearness=MODEL.clearness + 0.4,
        shown=0.0,
    )
    assert frame_log_likelihood_ratio(low._replace(shown=MODEL.enough_shown)) > 3.0
    assert frame_log_likelihood_ratio(low._replace(shown=MODEL.least_shown)) < 0.0
    assert (
        frame_log_likelihood_ratio(
            low._replace(shown=MODEL.enough_shown, clearness=MODEL.clearness)
        )
        < 0.0
    )
