import numpy as np
import pytest

from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.frame_sampler import (
    ELSEWHERE_MARGIN,
    ExpectedPlace,
    choose_columns,
    proposal_counts,
)


@pytest.mark.parametrize("count", [10, 100, 501])
@pytest.mark.parametrize("has_peaks", [True, False])
def test_every_particle_is_drawn_by_one_part(count, has_peaks):
    counts = proposal_counts(TargetParameters(particle_count=count), has_peaks=has_peaks)
    assert sum(counts) == count
    assert min(counts.followed, counts.search + 1, counts.refined + 1) >= 1
    assert (counts.peaks > 0) is has_peaks


def test_of_a_handful_all_follow():
    parameters = TargetParameters(
        particle_count=10, place_share=0.35, search_share=0.25, refinement_share=0.35
    )
    assert proposal_counts(parameters, has_peaks=True) == (10, 0, 0, 0)


def test_columns_are_chosen_by_their_shares():
    values = np.tile([1.0, 2.0, 0.0, 1.0], (4, 1))
    chosen = choose_columns(values, np.array([0.0, 0.26, 0.74, 0.99]))
    assert list(chosen) == [0, 1, 1, 3]


POSES = np.array([[2.0, 1.0, 0, 0, 0, 0], [60.0, 0, 0, 0, 0, 0], [0.0, -9.0, 0, 0, 0, 0]])
"""Here, elsewhere, here."""

PLACE = ExpectedPlace(0.0, 0.0, 10.0)


def test_what_is_farther_than_the_reach_is_elsewhere():
    assert PLACE.is_elsewhere(POSES).tolist() == [False, True, False]


def test_while_the_target_is_seen_here_a_better_place_elsewhere_is_worse_by_the_margin():
    scores = np.array([5.0, 6.5, 4.0])
    own = PLACE.with_penalty(POSES, scores, least=4.5).own_scores(POSES, scores)
    assert own == pytest.approx([5.0, 5.0 - ELSEWHERE_MARGIN, 4.0])


def test_a_worse_place_elsewhere_loses_the_margin_only():
    scores = np.array([5.0, 3.0, 4.0])
    own = PLACE.with_penalty(POSES, scores, least=4.5).own_scores(POSES, scores)
    assert own == pytest.approx([5.0, 3.0 - ELSEWHERE_MARGIN, 4.0])


def test_what_is_not_seen_here_may_be_elsewhere():
    scores = np.array([4.0, 6.5, 3.0])
    place = PLACE.with_penalty(POSES, scores, least=4.5)
    np.testing.assert_array_equal(place.own_scores(POSES, scores), scores)


def test_poses_on_one_side_only_are_no_error():
    scores = np.array([5.0, 6.0])
    assert PLACE.with_penalty(POSES[[0, 2]], scores, 4.5).score_penalty == pytest.approx(
        ELSEWHERE_MARGIN
    )
    assert PLACE.with_penalty(POSES[[1, 1]], scores, 4.5).score_penalty == 0.0
