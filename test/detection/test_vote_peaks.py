from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.detection.vote_peaks import (
    ANGLE_BINS,
    ANGLE_MARGIN,
    clearness_of,
    highest_about,
    strongest_lines,
)


def test_a_line_across_ripples_is_clearer_than_the_ripples(rng):
    votes = rng.exponential(1.0, (30, 41)).astype(np.float32)
    votes[10] += 30.0 * rng.random(41).astype(np.float32)
    votes[20, 15] += 20.0
    clear = clearness_of(votes)
    assert votes[10].max() > votes[20, 15]
    assert np.unravel_index(clear.argmax(), clear.shape) == (20, 15)
    assert (clear >= 0.0).all()


@given(row=st.floats(4.0, 20.0), column=st.floats(4.0, 36.0))
def test_a_peak_is_located_between_its_bins(row, column):
    rows, columns = np.mgrid[:30, :41]
    votes = np.exp(-0.5 * ((rows - row) ** 2 + (columns - column) ** 2) / 1.5**2)
    angles, offsets, supports = strongest_lines(votes.astype(np.float32), 3.0, 24)
    assert angles[0] == pytest.approx(row * 2 * np.pi / ANGLE_BINS, abs=0.02)
    assert offsets[0] == pytest.approx((column - 20) * 3.0, abs=0.6)
    assert supports[0] == supports.max() > 0.0


def test_a_peak_may_lie_across_the_seam_of_the_angles(rng):
    votes = rng.random((ANGLE_BINS, 41)).astype(np.float32)
    votes[[0, -1], 20] += 20.0
    angles, offsets, supports = strongest_lines(votes, 3.0, 24)
    assert offsets[0] == pytest.approx(0.0, abs=0.5)
    assert abs(np.sin(angles[0])) < 2 * np.pi / ANGLE_BINS
    assert supports[1] < 0.5 * supports[0]


def test_at_most_the_wanted_number_of_lines_comes_clearest_first(rng):
    votes = rng.exponential(1.0, (40, 31)).astype(np.float32)
    few, many = (strongest_lines(votes, 3.0, most)[2] for most in (5, 1000))
    assert (np.diff(many) <= 0.0).all()
    np.testing.assert_array_equal(few, many[:5])


def test_a_frame_without_votes_has_no_lines():
    assert all(len(each) == 0 for each in strongest_lines(np.zeros((40, 31)), 3.0, 24))


def test_the_highest_about_a_cell_is_that_of_its_neighbours_and_itself(rng):
    clear = rng.exponential(1.0, (20, 9)).astype(np.float32)
    inner = slice(ANGLE_MARGIN, -ANGLE_MARGIN)
    window = np.ones((2 * ANGLE_MARGIN + 1, 3), np.uint8)
    np.testing.assert_array_equal(highest_about(clear)[inner], cv2.dilate(clear, window)[inner])
