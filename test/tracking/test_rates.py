from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.tracking.parameter_table import REFERENCE_RATE
from cable_tracker.tracking.rates import (
    LEAST_FADING,
    SEARCH_SHARE,
    SurvivalRates,
    event_probability,
    over_time,
    share_about_last_place,
    share_over_time,
    survival_probability,
    survival_rates,
)

RATES = SurvivalRates(vanishing=0.25, leaving=10.0, margin=8.0)


def test_a_factor_acts_once_per_reference_frame():
    assert over_time(0.9, 2.0 / REFERENCE_RATE) == pytest.approx(0.81)
    assert over_time(0.9, 0.0) == 1.0


@pytest.mark.parametrize("rate", [0.0, 1e-12, 0.7, 50.0])
def test_the_probability_of_an_event_follows_from_its_rate(rate):
    assert event_probability(rate, 0.0) == 0.0
    assert event_probability(rate, 1e-3) == pytest.approx(rate * 1e-3, rel=0.03)
    assert event_probability(rate, 1.0) == pytest.approx(1.0 - math.exp(-rate), abs=1e-12)


def test_shares_of_the_way_add_up_over_frames():
    assert share_over_time(0.08, 0.04) == 0.08
    left = (1.0 - share_over_time(0.08, 0.01)) ** 4
    assert 1.0 - left == pytest.approx(0.08)
    assert [share_over_time(share, 3.0) for share in (0.0, 1.0)] == [0.0, 1.0]


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
