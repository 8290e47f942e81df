import math

import pytest

from cable_tracker.tracking.parameter_table import REFERENCE_RATE
from cable_tracker.tracking.rates import event_probability, over_time, share_over_time


def test_a_factor_acts_once_per_reference_frame():
    assert over_time(0.9, 2.0 / REFERENCE_RATE) == pytest.approx(0.81)
    assert over_time(0.9, 0.0) == 1.0


@pytest.mark.parametrize("rate", [0.0, 1e-12, 0.7, 50.0])
def test_an_event_is_as_likely_as_its_rate_says(rate):
    assert event_probability(rate, 0.0) == 0.0
    assert event_probability(rate, 1e-3) == pytest.approx(rate * 1e-3, rel=0.03)
    assert event_probability(rate, 1.0) == pytest.approx(1.0 - math.exp(-rate), abs=1e-12)


def test_shares_of_the_way_add_up_over_frames():
    assert share_over_time(0.08, 0.04) == 0.08
    left = (1.0 - share_over_time(0.08, 0.01)) ** 4
    assert 1.0 - left == pytest.approx(0.08)
    assert [share_over_time(share, 3.0) for share in (0.0, 1.0)] == [0.0, 1.0]
