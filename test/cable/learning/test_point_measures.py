from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from measured_points import points

NUMBERS = st.floats(-1e6, 1e6, width=32)


@given(NUMBERS, NUMBERS, NUMBERS)
def test_a_negative_of_a_negative_is_the_picture_and_slopes_have_no_sign(response, slope, contrast):
    measured = points(response, slope, contrast)
    twice = measured.negative().negative()
    assert twice.cells() == measured.cells()
    assert points(response, -slope, contrast).cells() == measured.cells()
