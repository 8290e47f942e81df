from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from measured_points import points

from cable_tracker.cable.measure.borders.response_bins import (
    CONTRAST_BINS,
    CONTRAST_SHAPE,
    EDGE_SHAPE,
    point_cell,
)

NUMBERS = st.floats(-1e6, 1e6, width=32)


@given(NUMBERS, NUMBERS, NUMBERS)
def test_every_point_has_a_cell(response, slope, contrast):
    measured = points(response, slope, contrast)
    (edge,), (contrast_cell,) = measured.cells()
    assert 0 <= edge < np.prod(EDGE_SHAPE)
    assert 0 <= contrast_cell < np.prod(CONTRAST_SHAPE)
    row = point_cell(np.float32(response), np.float32(abs(slope)), np.float32(contrast))
    assert divmod(int(row), CONTRAST_BINS) == (edge, contrast_cell % CONTRAST_BINS)
