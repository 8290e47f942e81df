from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.width_prior import (
    WidthPrior,
    updated_width_prior,
    width_penalty,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters(width_spread=0.3, width_time=2.0, width_memory=4.0)


def factors(usual, widths) -> np.ndarray:
    spread = usual.spread(PARAMETERS)
    return np.array([width_penalty(width, usual.log_width, spread) for width in widths])


@given(st.floats(3.0, 200.0), st.floats(0.01, 2.0), st.floats(0.01, 1.0))
def test_the_usual_width_fits_best_and_others_the_worse_the_farther(width, far, farther):
    ratios = np.exp([0.0, far, far + farther, -far, -far - farther])
    values = factors(WidthPrior(math.log(width)), width * ratios)
    assert values[0] == pytest.approx(0.0, abs=1e-9)
    assert values[0] > values[1] > values[2]
    # As much narrower is as bad as as much wider.
    np.testing.assert_allclose(values[3:], values[1:3], atol=1e-6)


def test_it_says_less_the_longer_no_cable_is_seen():
    usual = WidthPrior(math.log(30.0))
    now, soon, late = (factors(usual.aged(s), [60.0])[0] for s in (0.0, 4.0, 4000.0))
    assert now < soon < late < 0.0
    assert late == pytest.approx(0.0, abs=1e-3)
    assert usual.aged(1.0).aged(2.0).untracked_time == 3.0


def test_it_says_more_the_longer_a_cable_was_seen():
    young, old = (WidthPrior(math.log(30.0), tracked_time=s) for s in (0.0, 60.0))
    assert factors(old, [60.0])[0] < factors(young, [60.0])[0] < 0.0


def test_widths_of_nothing_and_less_are_bad_but_no_error():
    assert np.isfinite(factors(WidthPrior(math.log(30.0)), [0.0, -5.0])).all()


def test_without_a_prior_any_width_will_do():
    assert width_penalty(7.0, 0.0, math.inf) == 0.0


def test_the_first_width_is_the_usual_one():
    assert updated_width_prior(None, 30.0, 0.04, PARAMETERS) == WidthPrior(math.log(30.0))


def test_the_mean_follows_within_its_time_and_is_seen_again():
    usual = WidthPrior(math.log(30.0), untracked_time=3.0)
    for _ in range(50):
        usual = updated_width_prior(usual, 60.0, 0.04, PARAMETERS)
    assert usual.untracked_time == 0.0
    assert usual.log_width - math.log(30.0) == pytest.approx((1 - math.exp(-1)) * math.log(2.0))


@given(st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_it_is_time_that_counts_not_frames(first, second):
    usual = WidthPrior(math.log(30.0))
    twice = updated_width_prior(
        updated_width_prior(usual, 60.0, first, PARAMETERS), 60.0, second, PARAMETERS
    )
    once = updated_width_prior(usual, 60.0, first + second, PARAMETERS)
    assert twice.log_width == pytest.approx(once.log_width)
