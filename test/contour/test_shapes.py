import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.contour.shapes import (
    chain_code,
    feature_points,
    histogram_energy,
    level_set_energy,
    log_odds,
    segment_histograms,
    shape_energy,
    signed_distances,
    turns,
)
from cable_tracker.errors import FrameError

COLUMN_STEPS = np.array([1, 1, 0, -1, -1, -1, 0, 1])
ROW_STEPS = np.array([0, -1, -1, -1, 0, 1, 1, 1])


def test_distances_are_those_to_the_nearest_pixel_on_the_other_side():
    mask = np.random.default_rng(1).random((9, 11)) < 0.4
    places = np.argwhere(np.ones_like(mask))
    padded = {side: np.argwhere(np.pad(mask, 1) == side) - 1 for side in (True, False)}
    for place, signed in zip(places, signed_distances(mask).ravel(), strict=True):
        inside = mask[tuple(place)]
        nearest = np.hypot(*(padded[not inside] - place).T).min()
        assert signed == pytest.approx(0.5 - nearest if inside else nearest - 0.5, abs=1e-4)


def test_odds_are_even_at_the_outline_and_limited_far_from_it():
    mask = np.zeros((30, 30), bool)
    mask[10:20, 10:20] = True
    odds = log_odds(signed_distances(mask), softness=2.0, limit=2.0)
    assert odds[15, 10] == pytest.approx(0.25)
    assert odds[15, 9] == pytest.approx(-0.25)
    assert odds[15, 15] == odds.max() == 2.0
    assert odds[0, 0] == odds.min() == -2.0


def test_an_empty_mask_is_far_from_everything():
    assert (log_odds(signed_distances(np.zeros((5, 5), bool)), 1.0, 3.0) == -3.0).all()


def test_equal_masks_have_equal_distances_wherever_they_lie_in_memory():
    rng = np.random.default_rng(3)
    rows, columns = np.mgrid[:61, :75]
    mask = (rows - 30) ** 2 / 18**2 + (columns - 37) ** 2 / 24**2 < 1
    mask[20] = rng.random(75) < 0.5
    expected = signed_distances(mask)
    for size in rng.integers(1, 5000, 40):
        moved = np.zeros(size + mask.size, bool)[size:].reshape(mask.shape)
        moved[...] = mask
        np.testing.assert_array_equal(signed_distances(moved), expected)


def points_of(mask: np.ndarray, orientations: np.ndarray) -> list[tuple[int, int]]:
    """Return row and column of every point of a chain, from the first of the mask to it again."""
    steps = np.stack((ROW_STEPS[orientations], COLUMN_STEPS[orientations]), axis=1)
    return [tuple(p) for p in np.vstack((np.argwhere(mask)[:1], steps)).cumsum(axis=0).tolist()]


def outermost(mask: np.ndarray) -> set[tuple[int, int]]:
    """Return the points of the first region that have a 4-neighbour in what surrounds it."""
    wide = np.pad(mask, 1).astype(np.uint8)
    _, regions = cv2.connectedComponents(wide, connectivity=8)
    _, others = cv2.connectedComponents((regions != regions[wide > 0][0]).astype(np.uint8), None, 4)
    around = others == others[0, 0]
    touched = np.zeros_like(around)
    for axis in (0, 1):
        for step in (-1, 1):
            touched |= np.roll(around, step, axis)
    return {(row - 1, column - 1) for row, column in np.argwhere(touched & (others == 0)).tolist()}


def test_a_rectangle_is_walked_round_counter_clockwise():
    mask = np.zeros((8, 9), bool)
    mask[2:5, 3:8] = True
    assert chain_code(mask).tolist() == [6] * 2 + [0] * 4 + [2] * 2 + [4] * 4


def test_a_single_point_has_no_steps():
    mask = np.zeros((3, 3), bool)
    mask[2, 0] = True
    assert len(chain_code(mask)) == 0


@given(st.integers(0, 2**32 - 1))
def test_the_chain_closes_and_visits_what_the_surroundings_touch(seed):
    mask = np.random.default_rng(seed).random((9, 11)) < 0.6
    mask[4, 5] = True
    points = points_of(mask, chain_code(mask))
    assert points[0] == points[-1]
    assert set(points) == outermost(mask)


def test_an_empty_mask_is_refused():
    with pytest.raises(FrameError, match="no outline"):
        chain_code(np.zeros((4, 4), bool))


def test_feature_points_are_those_of_table_3():
    orientations = np.array([0, 1, 2, 3, 3, 3, 3, 4, 4, 5, 7, 7, 6, 7, 0, 7, 0])
    assert feature_points(orientations) == [0, 8]


def test_turns_go_the_short_way():
    assert turns(np.array([7, 0, 7, 3, 4, 1])).tolist() == [1, -1, 4, 1, -3]


def test_segments_share_the_chain_between_them():
    orientations = np.array([0, 1, 2, 3, 3, 3, 3, 4, 4, 5, 7, 7, 6, 7, 0, 7, 0])
    histograms = segment_histograms(orientations)
    assert histograms[0] == pytest.approx(np.array([1, 1, 1, 4, 1, 0, 0, 0]) / 8)
    assert histograms.sum(axis=1) == pytest.approx([1.0, 1.0])


def test_the_same_shape_has_no_energy(draw_disc):
    disc = draw_disc(50, 50, (25, 25), 10)
    assert shape_energy(disc, disc, 1.0, 1.0) == 0.0


def test_discs_of_other_radius_are_as_far_apart_as_their_radii(draw_disc):
    small, large = (draw_disc(80, 80, (40, 40), radius) for radius in (15, 20))
    assert level_set_energy(small, large) == pytest.approx(25.0, rel=0.15)
    assert level_set_energy(small, large) == level_set_energy(large, small)


def test_histograms_without_a_partner_count_in_full():
    one, two = np.eye(8)[:1], np.eye(8)[:2]
    assert histogram_energy(one, one) == 0.0
    assert histogram_energy(one, two) == histogram_energy(two, one) == 1.0


def test_both_energies_are_weighted(draw_disc):
    disc, square = draw_disc(50, 50, (25, 25), 10), np.zeros((50, 50), bool)
    square[15:36, 15:36] = True
    levels, both = shape_energy(disc, square, 1.0, 0.0), shape_energy(disc, square, 2.0, 3.0)
    assert both > 2.0 * levels > 0.0


def test_what_cannot_be_compared_is_refused(draw_disc):
    disc = draw_disc(50, 50, (25, 25), 10)
    with pytest.raises(FrameError, match="compared"):
        level_set_energy(disc, disc[1:])
    with pytest.raises(FrameError, match="empty"):
        level_set_energy(disc, np.zeros_like(disc))
