from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.weigh.thin_strips import (
    thin_factor,
    trusted_appearance,
)


def test_thin_strips_count_less_but_something():
    factors = [thin_factor(width, 12.0) for width in (0.0, 3.0, 6.0, 12.0, 100.0)]
    assert factors == pytest.approx([0.5, 0.5, math.sqrt(0.5), 1.0, 1.0])


@given(st.floats(0.1, 500.0), st.floats(-20.0, 20.0))
def test_looks_speak_for_wide_strips_alone_and_against_all(width, appearance):
    trusted = trusted_appearance(appearance, width, 12.0)
    assert min(appearance, 0.0) - 1e-9 <= trusted <= max(appearance, 0.0) + 1e-9
    if width >= 24.0 or appearance <= 0.0:
        assert trusted == pytest.approx(appearance)
    elif width <= 16.0:
        assert trusted == 0.0
