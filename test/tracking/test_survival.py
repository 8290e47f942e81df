from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.tracking.survival import (
    LEAST_FADING,
    SEARCH_SHARE,
    SurvivalRates,
    share_about_last_place,
    survival_probability,
    survival_rates,
)

RATES = SurvivalRates(vanishing=0.25, leaving=10.0, margin=8.0)


def test_in_the_middle_only_vanishing_counts_and_beyond_the_edge_both():
    survival = [survival_probability(inside, RATES, 0.5) for inside in (1000.0, 0.0, -1000.0)]
    expected = [math.exp(-rate * 0.5) for rate in (0.25, 5.25, 10.25)]
    assert survival == pytest.approx(expected)


@given(st.floats(-1e6, 1e6), st.floats(0.0, 2.0), st.floats(0.0, 2.0))
def test_surviving_two_times_is_surviving_their_sum(inside, first, second):
    both = survival_probability(inside, RATES, first) * survival_probability(inside, RATES, second)
    assert both == pytest.approx(survival_probability(inside, RATES, first + second))


def test_the_last_place_is_forgotten_but_never_quite():
    shares = [share_about_last_place(seconds, 4.0) for seconds in (0.0, 4.0, 1e6)]
    most = 1.0 - SEARCH_SHARE
    assert shares == pytest.approx([most, most / math.e, most * LEAST_FADING])


def test_the_margin_grows_with_the_picture():
    assert survival_rates(*RATES, 320) == RATES
    assert survival_rates(*RATES, 640) == RATES._replace(margin=16.0)
