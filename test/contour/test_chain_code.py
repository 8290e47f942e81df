import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.contour.chain_code import (
    chain_code,
    feature_points,
    segment_histograms,
    turns,
)
from cable_tracker.errors import FrameError

COLUMN_STEPS = np.array([1, 1, 0, -1, -1, -1, 0, 1])
ROW_STEPS = np.array([0, -1, -1, -1, 0, 1, 1, 1])


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
