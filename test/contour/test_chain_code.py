import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.contour.chain_code import COLUMN_STEPS, ROW_STEPS, outline
from cable_tracker.errors import FrameError


def test_a_rectangle_is_walked_round_counter_clockwise():
    mask = np.zeros((8, 9), bool)
    mask[2:5, 3:8] = True
    chain = outline(mask)
    assert chain.orientations.tolist() == [6] * 2 + [0] * 4 + [2] * 2 + [4] * 4
    assert chain.points[:4].tolist() == [[3, 2], [3, 3], [3, 4], [4, 4]]


def test_a_single_point_has_no_steps():
    mask = np.zeros((3, 3), bool)
    mask[2, 0] = True
    chain = outline(mask)
    assert chain.points.tolist() == [[0, 2]]
    assert len(chain.orientations) == 0


@given(st.integers(0, 2**32 - 1))
def test_the_chain_closes_and_visits_the_points_that_opencv_visits(seed):
    mask = np.random.default_rng(seed).random((9, 11)) < 0.6
    mask[4, 5] = True
    chain = outline(mask)
    steps = np.stack((COLUMN_STEPS[chain.orientations], ROW_STEPS[chain.orientations]), axis=1)
    assert (steps.sum(axis=0) == 0).all()
    if len(steps):
        np.testing.assert_array_equal(np.roll(chain.points, -1, axis=0) - chain.points, steps)
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    first = chain.points[0].tolist()
    (same,) = [each[:, 0] for each in contours if first in each[:, 0].tolist()]
    assert {tuple(p) for p in chain.points.tolist()} == {tuple(p) for p in same.tolist()}


def test_an_empty_mask_is_refused():
    with pytest.raises(FrameError, match="no outline"):
        outline(np.zeros((4, 4), bool))
