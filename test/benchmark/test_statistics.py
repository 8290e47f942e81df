import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.benchmark.statistics import Percentiles, Quartiles, fit_line


def test_quartiles_and_percentiles_of_known_numbers():
    middle = Quartiles.of(np.arange(101.0))
    assert (middle.low, middle.median, middle.high, middle.count) == (25.0, 50.0, 75.0, 101)
    tail = Percentiles.of(np.arange(101.0))
    assert (tail.median, tail.p95, tail.p99, tail.count) == (50.0, 95.0, 99.0, 101)


@given(
    st.floats(0.01, 10.0),
    st.floats(1e-6, 1e-3),
    st.lists(st.integers(1, 100_000), min_size=2, max_size=8, unique=True),
)
def test_a_line_is_found_again(base, slope, amounts):
    base_found, slope_found = fit_line(amounts, [base + slope * amount for amount in amounts])
    for amount in amounts:
        assert base_found + slope_found * amount == pytest.approx(base + slope * amount, rel=1e-6)


def test_small_costs_count_as_much_as_large_ones():
    base, slope = fit_line([1, 2, 1000], [1.0, 2.0, 500.0])
    assert base + slope * 1 == pytest.approx(1.0, rel=0.5)
