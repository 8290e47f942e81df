from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.borders.polarity_prior import (
    bright_share,
    marginal_log_ratios,
    polarity_prior,
)

RATIOS, PROBABILITIES = st.floats(-50, 50), st.floats(0.02, 0.98)


@given(RATIOS, RATIOS, PROBABILITIES)
def test_an_unknown_polarity_is_averaged_over(bright, dark, probability):
    polarity = polarity_prior(probability)
    expected = probability * np.exp(bright) + (1 - probability) * np.exp(dark)
    marginal = marginal_log_ratios(np.array([[bright, dark]]), polarity)[0]
    assert marginal == pytest.approx(np.log(expected))
    share = bright_share(polarity, bright, dark)
    assert share == pytest.approx(probability * np.exp(bright) / expected)


def test_shares_of_extreme_ratios_are_no_overflow():
    even = polarity_prior(0.5)
    assert bright_share(even, 1e4, 0.0) == pytest.approx(1.0)
    assert bright_share(even, 0.0, 1e4) == pytest.approx(0.0, abs=1e-12)
