import math

import pytest

from cable_tracker.evaluation.spread import spread_of


def test_spread_by_hand():
    spread = spread_of([1.0, 2.0, math.nan, 6.0])
    assert (spread.count, spread.mean, spread.median) == (3, 3.0, 2.0)
    assert (spread.minimum, spread.maximum) == (1.0, 6.0)
    assert spread.standard_error == pytest.approx(math.sqrt(7.0 / 3.0))  # variance 14 / 2


def test_one_run_has_no_standard_error():
    assert math.isnan(spread_of([4.0]).standard_error)


def test_an_infinite_number_stays_infinite():
    assert spread_of([1.0, math.inf]).mean == math.inf


def test_nothing_is_unknown():
    spread = spread_of([math.nan])
    assert spread.count == 0
    assert math.isnan(spread.mean)
