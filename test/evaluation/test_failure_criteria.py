import math

import numpy as np
import pytest

from cable_tracker.evaluation.failure_criteria import forgiven_distance, is_off_cable

DEGREE = np.pi / 180


def errors(*rows):
    return np.array([(*row, 0.0, 0.0) for row in rows])


def test_ten_pixels_are_forgiven_of_a_thin_cable_and_half_the_width_of_a_wide_one():
    off = errors((9.9, 0.0), (-10.1, 0.0), (14.9, 0.0), (-15.1, 0.0))
    widths = np.array([4.0, 4.0, 30.0, 30.0])
    assert is_off_cable(off, widths, forgiven=forgiven_distance(320)).tolist() == [
        False,
        True,
        False,
        True,
    ]


def test_the_ten_pixels_grow_with_the_image():
    off = errors((39.9, 0.0), (40.1, 0.0))
    assert is_off_cable(off, np.array([4.0, 4.0]), forgiven=forgiven_distance(1280)).tolist() == [
        False,
        True,
    ]


def test_no_pixels_are_forgiven_outside_the_borders():
    off = errors((2.0, 0.0), (-2.1, 0.0), (15.0, 0.0), (-15.1, 0.0))
    widths = np.array([4.0, 4.0, 30.0, 30.0])
    assert is_off_cable(off, widths, forgiven=0.0).tolist() == [False, True, False, True]


@pytest.mark.parametrize("forgiven", [0.0, 10.0])
def test_eight_degrees_are_too_much_and_width_and_taper_do_not_count(forgiven):
    off = np.array([(0.0, 8 * DEGREE, 99.0, 1.0), (0.0, -8.1 * DEGREE, 0.0, 0.0)])
    assert is_off_cable(off, np.array([30.0, 30.0]), forgiven=forgiven).tolist() == [False, True]


@pytest.mark.parametrize("forgiven", [0.0, 10.0])
def test_an_error_that_is_no_number_is_off_the_cable(forgiven):
    assert is_off_cable(errors((math.nan, 0.0)), np.array([30.0]), forgiven=forgiven).all()
