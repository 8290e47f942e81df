from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measured_points import points

from cable_tracker.cable.measure.borders.response_bins import (
    CONTRAST_BINS,
    CONTRAST_SHAPE,
    EDGE_SHAPE,
    border_strength,
    point_cell,
    strength_class,
)

NUMBERS = st.floats(-1e6, 1e6, width=32)


def test_the_strength_of_a_border_is_the_mean_of_its_upper_half():
    assert border_strength(np.array([5.0, -9.0, 3.0, 0.0], np.float32)) == pytest.approx(4.0)
    assert border_strength(np.array([1.0, 7.0, 3.0], np.float32)) == pytest.approx(5.0)
    classes = [strength_class(strength) for strength in (0.0, 1.19, 1.2, 2.0, 3.9, 99.0)]
    assert classes == [-1, -1, 0, 1, 2, 3]


@given(NUMBERS, NUMBERS, NUMBERS)
def test_every_point_has_a_cell(response, slope, contrast):
    measured = points(response, slope, contrast)
    (edge,), (contrast_cell,) = measured.cells()
    assert 0 <= edge < np.prod(EDGE_SHAPE)
    assert 0 <= contrast_cell < np.prod(CONTRAST_SHAPE)
    row = point_cell(np.float32(response), np.float32(abs(slope)), np.float32(contrast))
    assert divmod(int(row), CONTRAST_BINS) == (edge, contrast_cell % CONTRAST_BINS)


@given(NUMBERS, NUMBERS, NUMBERS)
def test_a_negative_of_a_negative_is_the_picture_and_slopes_have_no_sign(response, slope, contrast):
    measured = points(response, slope, contrast)
    twice = measured.negative().negative()
    assert twice.cells() == measured.cells()
    assert points(response, -slope, contrast).cells() == measured.cells()
