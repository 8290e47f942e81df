import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.arrays import (
    eight_bits,
    interpolated,
    mean_and_covariance,
    shares_of,
    sigma_points,
    true_runs,
)

KNOWN = np.array([0.0, 2.0, 4.0])
COLUMNS = np.array([[0.0, 10.0], [2.0, 20.0], [2.0, 40.0]])

MEAN = np.array([100.0, 0.1, -3.0])
COVARIANCE = np.array([[4.0, 0.002, 0.0], [0.002, 1e-4, 0.001], [0.0, 0.001, 0.5]])


def test_grey_levels_are_rounded_and_clipped():
    levels = eight_bits(np.array([[-3.0, 0.4, 0.6], [254.6, 255.4, 300.0]], np.float32))
    assert levels.dtype == np.uint8
    assert levels.tolist() == [[0, 0, 1], [255, 255, 255]]


def test_eight_bits_stay_as_they_are():
    image = np.arange(6, dtype=np.uint8).reshape(2, 3)
    assert eight_bits(image) is image


@given(st.lists(st.booleans(), max_size=30))
def test_runs_cover_the_mask_and_nothing_else(flags):
    mask = np.array(flags, bool)
    covered = np.zeros(len(flags), bool)
    last_end = -1
    for start, end in true_runs(mask):
        assert last_end < start < end
        covered[start:end] = True
        last_end = end
    assert (covered == mask).all()


def test_columns_are_straight_between_what_is_known_and_level_outside():
    found = interpolated(np.array([-1.0, 1.0, 3.0, 9.0]), KNOWN, COLUMNS)
    assert found.tolist() == [[0.0, 10.0], [1.0, 15.0], [2.0, 30.0], [2.0, 40.0]]


def test_a_single_place_is_interpolated_to_one_row():
    assert interpolated(3.0, KNOWN, COLUMNS).tolist() == [2.0, 30.0]


def test_shares_sum_to_one_and_are_even_where_there_is_nothing():
    assert shares_of(np.array([1.0, 0.0, 3.0])).tolist() == [0.25, 0.0, 0.75]
    assert shares_of(np.zeros(4)).tolist() == [0.25] * 4


def test_the_points_have_the_mean_and_the_covariance():
    points = sigma_points(MEAN, COVARIANCE)
    assert points.shape == (6, 3)
    mean, covariance = mean_and_covariance(points)
    np.testing.assert_allclose(mean, MEAN)
    np.testing.assert_allclose(covariance, COVARIANCE, atol=1e-12)


def test_a_component_without_doubt_stays_where_it_is():
    points = sigma_points(MEAN, np.diag([1.0, 0.0, 2.0]))
    assert (points[:, 1] == 0.1).all()


def test_the_mean_of_a_square_is_exact():
    points = sigma_points(MEAN, COVARIANCE)
    assert (points[:, 2] ** 2).mean() == pytest.approx(9.0 + 0.5)
