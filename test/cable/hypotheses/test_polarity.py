from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.polarity import POLARITY_DOUBT, updated_p_bright

shares = st.floats(0.0, 1.0)


@given(shares, shares, shares, shares, st.floats(0.0, 100.0))
def test_the_polarity_is_never_beyond_doubt(before, found, presence, memory, dt):
    after = updated_p_bright(before, found, presence, memory, dt)
    assert POLARITY_DOUBT <= after <= 1.0 - POLARITY_DOUBT


def test_a_frame_without_a_cable_says_nothing_of_its_polarity():
    assert updated_p_bright(0.8, 0.0, 0.0, 1.0, 0.04) == pytest.approx(0.8)
    assert updated_p_bright(0.8, 0.1, 1.0, 1.0, 0.04) == pytest.approx(0.1)


def test_what_was_known_is_forgotten_with_time():
    soon, late = (updated_p_bright(0.9, 0.9, 0.0, 0.9, dt) for dt in (0.04, 4.0))
    assert 0.5 < late < soon < 0.9
