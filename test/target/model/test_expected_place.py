import numpy as np
import pytest

from cable_tracker.target.model.expected_place import MARGIN, ExpectedPlace

POSES = np.array([[2.0, 1.0, 0, 0, 0, 0], [60.0, 0, 0, 0, 0, 0], [0.0, -9.0, 0, 0, 0, 0]])
"""Here, elsewhere, here."""

PLACE = ExpectedPlace(0.0, 0.0, 10.0)


def test_what_is_farther_than_the_reach_is_elsewhere():
    assert PLACE.is_elsewhere(POSES).tolist() == [False, True, False]


def test_while_the_target_is_seen_here_a_better_place_elsewhere_is_worse_by_the_margin():
    scores = np.array([5.0, 6.5, 4.0])
    own = PLACE.seen(POSES, scores, least=4.5).own_scores(POSES, scores)
    assert own == pytest.approx([5.0, 5.0 - MARGIN, 4.0])


def test_a_worse_place_elsewhere_loses_the_margin_only():
    scores = np.array([5.0, 3.0, 4.0])
    own = PLACE.seen(POSES, scores, least=4.5).own_scores(POSES, scores)
    assert own == pytest.approx([5.0, 3.0 - MARGIN, 4.0])


def test_what_is_not_seen_here_may_be_elsewhere():
    scores = np.array([4.0, 6.5, 3.0])
    place = PLACE.seen(POSES, scores, least=4.5)
    np.testing.assert_array_equal(place.own_scores(POSES, scores), scores)


def test_poses_on_one_side_only_are_no_error():
    scores = np.array([5.0, 6.0])
    assert PLACE.seen(POSES[[0, 2]], scores, 4.5).score_penalty == pytest.approx(MARGIN)
    assert PLACE.seen(POSES[[1, 1]], scores, 4.5).score_penalty == 0.0
