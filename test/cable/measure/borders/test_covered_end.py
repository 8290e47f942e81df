"""One end of a cable may be covered: what speaks against it from there on is left out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.borders.covered_end import (
    MOST_UNSEEN,
    SHOWN_PART,
    leave_out_covered_end,
)
from cable_tracker.cable.measure.borders.stretches import STRETCHES, has_stretch

COST = 6.0
SEEDS = st.integers(0, 2**32 - 1)


def summed(left, right, cost=COST) -> np.ndarray:
    """Return the sums of both borders of a cable by stretches of its borders."""
    return summed_and_covered(left, right, cost)[0]


def summed_and_covered(left, right, cost=COST) -> tuple[np.ndarray, list[int]]:
    """Return these sums, and the numbers of the stretches that are covered."""
    stretches = np.stack((left, right)).astype(np.float32)
    sums = stretches.sum(axis=1)
    covered = leave_out_covered_end(stretches, cost, sums)
    return sums, [k for k in range(STRETCHES) if has_stretch(covered, k)]


def with_covered(shown, hidden, first) -> np.ndarray:
    """Return stretches of which those before `first` show nothing."""
    return np.r_[np.full(first, hidden), np.full(STRETCHES - first, shown)]


@pytest.mark.parametrize("turned", [False, True])
def test_what_speaks_against_a_cable_from_one_end_on_costs_no_more_than_the_cover(turned):
    stretches = with_covered(3.0, -5.0, 6)
    border = stretches[::-1] if turned else stretches
    np.testing.assert_allclose(summed(border, border), [30.0 - COST / 2] * 2)


@pytest.mark.parametrize("turned", [False, True])
def test_what_is_covered_is_told(turned):
    stretches, covered = with_covered(3.0, -5.0, 6), range(6)
    border = stretches[::-1] if turned else stretches
    expected = range(STRETCHES - 6, STRETCHES) if turned else covered
    assert summed_and_covered(border, border)[1] == list(expected)
    assert summed_and_covered(np.abs(border), np.abs(border))[1] == []


def test_of_what_is_mostly_covered_nothing_is_to_be_looked_at_without():
    covered = int(MOST_UNSEEN * STRETCHES)
    told, more = (with_covered(3.0, -5.0, first) for first in (covered, covered + 1))
    assert summed_and_covered(told, told)[1] == list(range(covered))
    assert summed_and_covered(more, more)[1] == []


def test_a_cable_in_full_view_is_summed_as_it_is():
    border = np.full(STRETCHES, 2.0)
    np.testing.assert_allclose(summed(border, border), [32.0, 32.0])


def test_what_speaks_against_it_by_less_than_the_cost_counts():
    border = with_covered(3.0, -0.9, 3)
    np.testing.assert_allclose(summed(border, border), [39.0 - 2.7] * 2, rtol=1e-6)


def test_a_gap_between_two_ends_in_view_counts():
    border = np.full(STRETCHES, 3.0)
    border[6:9] = -5.0
    np.testing.assert_allclose(summed(border, border), [39.0 - 15.0] * 2)


def test_both_borders_end_at_one_place():
    left, right = with_covered(3.0, -5.0, 6), np.full(STRETCHES, 3.0)
    np.testing.assert_allclose(summed(left, right), [30.0 - COST / 2, 30.0 - COST / 2])


def test_a_third_of_what_is_in_view_is_left():
    border = with_covered(3.0, -5.0, STRETCHES - 2)
    covered = STRETCHES - -(-STRETCHES // SHOWN_PART)
    left_over = border[covered:].sum()
    np.testing.assert_allclose(summed(border, border), [left_over - COST / 2] * 2)


def test_a_short_cable_is_nowhere_covered():
    border = np.zeros(STRETCHES)
    border[5:8] = (-9.0, -9.0, 4.0)
    np.testing.assert_allclose(summed(border, border), [-14.0, -14.0])


@given(SEEDS, st.floats(0.0, 40.0))
def test_a_covered_end_is_one_for_which_the_sum_is_the_largest(seed, cost):
    left, right = np.random.default_rng(seed).normal(0.0, 10.0, (2, STRETCHES)).astype(np.float32)
    both = left + right
    best = both.sum()
    for count in range(1, STRETCHES - -(-STRETCHES // SHOWN_PART) + 1):
        best = max(best, both[count:].sum() - cost, both[:-count].sum() - cost)
    assert summed(left, right, cost).sum() == pytest.approx(best, abs=1e-3)
