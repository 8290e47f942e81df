from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.segments import band_about, border_segments, centreline_segments
from cable_tracker.cable.model.state import CableState

SIZE = (320, 240)
UPRIGHT = CableState(20.0, 0.0, 40.0)


def test_an_upright_cable_has_its_borders_half_a_width_aside():
    left, right = border_segments(UPRIGHT, SIZE)
    assert left == ((0.0, -119.5), (0.0, 119.5))
    assert right == ((40.0, -119.5), (40.0, 119.5))
    assert centreline_segments(UPRIGHT, SIZE) == [((20.0, -119.5), (20.0, 119.5))]


def test_lines_that_miss_the_image_are_left_out():
    at_the_edge = CableState(170.0, 0.0, 40.0)
    assert centreline_segments(at_the_edge, SIZE) == []
    assert border_segments(at_the_edge, SIZE) == [((150.0, -119.5), (150.0, 119.5))]


def test_the_band_is_two_standard_deviations_wide_where_only_the_distance_is_in_doubt():
    band = band_about(UPRIGHT, (3.0, 0.0), SIZE, 5)
    assert band.shape == (10, 2)
    np.testing.assert_allclose(band[:5, 0], 14.0)
    np.testing.assert_allclose(band[5:, 0], 26.0)
    assert (band[0, 1], band[4, 1]) == pytest.approx((-200.0, 200.0))


def test_a_doubtful_angle_widens_the_band_towards_its_ends():
    band = band_about(UPRIGHT, (3.0, 0.1), SIZE, 5)
    widths = band[9:4:-1, 0] - band[:5, 0]
    assert widths[2] == pytest.approx(12.0)
    assert (np.diff(widths)[:2] < 0.0).all() and (np.diff(widths)[2:] > 0.0).all()


def test_the_band_stays_finite_whatever_is_not_known():
    band = band_about(UPRIGHT, (1e6, 1e6), SIZE, 5)
    assert np.abs(band).max() < 1000.0
