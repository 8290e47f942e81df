from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_images import plain_image

from cable_tracker.cable.measure.borders.border_points import border_line
from cable_tracker.cable.measure.borders.response_table import CLASSES
from cable_tracker.cable.measure.borders.stretches import (
    MOST_UNSEEN,
    SHOWN_PART,
    STRETCHES,
    either_log_ratio,
    has_stretch,
    leave_out_covered_end,
    stretch_at,
    stretch_axis,
    stretch_scale,
    sum_stretches,
)
from cable_tracker.cable.model.geometry import border_side
from cable_tracker.cable.model.state import CableState

COSTS = st.floats(0.0, 40.0)
SEEDS = st.integers(0, 2**32 - 1)

COST = 6.0


def ratios(seed: int) -> np.ndarray:
    """Sums of both borders in each stretch, by polarity and class."""
    shape = (2, 2 * CLASSES, STRETCHES)
    return np.random.default_rng(seed).normal(0.0, 8.0, shape).astype(np.float32)


NEVER_COVERED = 1e6
NO_STRIPES = np.full((2, CLASSES), -1e6, np.float32)


def summed(stretches, cost, striped=NO_STRIPES):
    """Sums along the borders, and whether each stretch of a bright and of a dark cable is turned"""
    sums, found = np.empty((2, 2 * CLASSES), np.float32), np.empty(2, np.int64)
    sum_stretches(stretches, striped, cost, NEVER_COVERED, sums, found, np.empty(2, np.int64))
    turned = [[has_stretch(int(row), stretch) for stretch in range(STRETCHES)] for row in found]
    return sums, np.array(turned)


@given(SEEDS, COSTS)
def test_each_stretch_takes_the_likelier_polarity_at_the_cost_of_a_change(seed, cost):
    stretches = ratios(seed)
    sums, _ = summed(stretches, cost)
    both = stretches.sum(axis=0)
    swapped = np.roll(both, CLASSES, axis=0)
    best = np.maximum(both, swapped - cost).sum(axis=1)
    is_mostly_other = (swapped - cost > both).sum(axis=1) > STRETCHES / 2
    expected = np.where(is_mostly_other, both.sum(axis=1), best)
    np.testing.assert_allclose(sums.sum(axis=0), expected, atol=1e-3)


@given(SEEDS, COSTS)
def test_reversed_stretches_are_those_of_the_likeliest_strength(seed, cost):
    stretches = ratios(seed)
    sums, turned = summed(stretches, cost)
    both = stretches.sum(axis=0)
    for polarity in range(2):
        own = slice(polarity * CLASSES, (polarity + 1) * CLASSES)
        column = polarity * CLASSES + int(np.argmax(sums.sum(axis=0)[own]))
        gains = both[(column + CLASSES) % (2 * CLASSES)] - both[column]
        clear = np.abs(gains - cost) > 1e-3
        if (gains > cost).sum() > STRETCHES / 2:
            gains = np.full(STRETCHES, -1.0)
        np.testing.assert_array_equal(turned[polarity][clear], (gains > cost)[clear])


@given(SEEDS, st.integers(1, 12))
def test_stretches_out_of_view_do_not_count(seed, first):
    stretches = ratios(seed)
    stretches[:, :, first : first + 4] = 0.0
    sums, turned = summed(stretches, 6.0)
    assert not turned[:, first : first + 4].any()
    kept = np.r_[0:first, first + 4 : STRETCHES]
    packed = np.zeros_like(stretches)
    packed[:, :, : len(kept)] = stretches[:, :, kept]
    expected, _ = summed(packed, 6.0)
    np.testing.assert_allclose(sums, expected, atol=1e-3)


@given(SEEDS)
def test_each_border_pays_half_of_the_cost(seed):
    stretches = np.abs(ratios(seed)) + 1.0
    stretches[:, CLASSES:] *= -1.0
    stretches[:, :, 4:7] *= -1.0
    cost = 2.0
    sums, turned = summed(stretches, cost)
    assert np.flatnonzero(turned[0]).tolist() == [4, 5, 6]
    along = np.abs(stretches)
    along[:, :, 4:7] = np.roll(along, CLASSES, axis=1)[:, :, 4:7]
    expected = along.sum(axis=2)[:, :CLASSES] - 3 * 0.5 * cost
    np.testing.assert_allclose(sums[:, :CLASSES], expected, rtol=1e-5)


@given(SEEDS)
def test_at_a_high_cost_a_cable_is_of_one_polarity(seed):
    stretches = ratios(seed)
    sums, turned = summed(stretches, 1e6)
    np.testing.assert_allclose(sums, stretches.sum(axis=2), atol=1e-3)
    assert not turned.any()


@given(SEEDS)
def test_at_most_half_of_a_bright_cable_is_reversed(seed):
    stretches = ratios(seed)
    stretches[:, :CLASSES, :10] = -20.0
    stretches[:, CLASSES:, :10] = 20.0
    sums, turned = summed(stretches, 1.0)
    np.testing.assert_allclose(sums[:, :CLASSES], stretches.sum(axis=2)[:, :CLASSES], atol=1e-3)
    assert not turned[0].any()


@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
def test_a_point_of_either_polarity_says_hardly_less_than_the_mean_of_both(bright, dark):
    exact = np.logaddexp(bright, dark) - np.log(2.0)
    found = either_log_ratio(np.float32(bright), np.float32(dark))
    assert exact - 0.23 <= found <= exact + 1e-5


@given(SEEDS, COSTS, st.floats(-100.0, 400.0))
def test_a_cable_is_striped_where_that_is_likelier_and_most_of_it_has_its_polarity(
    seed, cost, level
):
    stretches = ratios(seed)
    striped = np.random.default_rng(seed + 1).normal(level, 20.0, (2, CLASSES)).astype(np.float32)
    plain, _ = summed(stretches, cost)
    sums, turned = summed(stretches, cost, striped)
    both = stretches.sum(axis=0)
    is_reversed_most = (np.roll(both, CLASSES, axis=0) > both).sum(axis=1) > STRETCHES / 2
    either = np.tile(striped.sum(axis=0) - cost, 2)
    is_striped = (either > plain.sum(axis=0) + 1e-3) & ~is_reversed_most
    expected = np.where(is_striped, np.tile(striped, 2) - 0.5 * cost, plain)
    clear = np.abs(either - plain.sum(axis=0)) > 1e-2
    np.testing.assert_allclose(sums[:, clear], expected[:, clear], atol=1e-2)
    assert (turned.sum(axis=1) <= STRETCHES / 2).all()


@given(SEEDS)
def test_a_striped_cable_reports_the_likelier_polarity_of_each_stretch(seed):
    stretches = ratios(seed)
    _, turned = summed(stretches, 1.0, np.full((2, CLASSES), 1e4, np.float32))
    both = stretches.sum(axis=0)
    for polarity in range(2):
        own, other = (both[p * CLASSES : (p + 1) * CLASSES] for p in (polarity, 1 - polarity))
        is_other = other > own
        allowed = np.flatnonzero(is_other.sum(axis=1) <= STRETCHES / 2)
        if len(allowed):
            # All strengths say as much here: the first one is kept.
            np.testing.assert_array_equal(turned[polarity], is_other[allowed[0]])


@given(st.floats(-1.5, 1.5), st.floats(-60.0, 60.0), st.floats(-0.3, 0.3))
def test_a_stretch_lies_across_the_cable_on_both_borders(angle, distance, skew):
    state = CableState(distance, angle, 40.0, skew).to_array()
    scan = plain_image(np.zeros((240, 320), np.uint8)).scan
    for border in range(2):
        line = border_line(state, border_side(border), scan)
        scale = stretch_scale(stretch_axis(state, scan), line)
        for place in (-50.0, 0.0, 70.0):
            along = line.start + line.step * place
            x, y = (along, place) if line.is_steep else (place, along)
            axial = y * np.cos(angle) - x * np.sin(angle)
            expected = np.clip((axial / 400.0 + 0.5) * STRETCHES, 0.0, STRETCHES - 1.0)
            assert stretch_at(scale, place) == pytest.approx(np.floor(expected), abs=1e-6) or (
                abs(expected - round(expected)) < 1e-6
            )


def summed_with_cover(left, right, cost=COST) -> np.ndarray:
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
def test_evidence_against_one_end_of_a_cable_costs_no_more_than_the_cover(turned):
    stretches = with_covered(3.0, -5.0, 6)
    border = stretches[::-1] if turned else stretches
    np.testing.assert_allclose(summed_with_cover(border, border), [30.0 - COST / 2] * 2)


@pytest.mark.parametrize("turned", [False, True])
def test_covered_stretches_are_reported(turned):
    stretches, covered = with_covered(3.0, -5.0, 6), range(6)
    border = stretches[::-1] if turned else stretches
    expected = range(STRETCHES - 6, STRETCHES) if turned else covered
    assert summed_and_covered(border, border)[1] == list(expected)
    assert summed_and_covered(np.abs(border), np.abs(border))[1] == []


def test_a_mostly_covered_cable_reports_no_covered_stretches():
    covered = int(MOST_UNSEEN * STRETCHES)
    told, more = (with_covered(3.0, -5.0, first) for first in (covered, covered + 1))
    assert summed_and_covered(told, told)[1] == list(range(covered))
    assert summed_and_covered(more, more)[1] == []


def test_a_cable_in_full_view_is_summed_as_it_is():
    border = np.full(STRETCHES, 2.0)
    np.testing.assert_allclose(summed_with_cover(border, border), [32.0, 32.0])


def test_evidence_against_one_end_below_the_cost_of_the_cover_counts():
    border = with_covered(3.0, -0.9, 3)
    np.testing.assert_allclose(summed_with_cover(border, border), [39.0 - 2.7] * 2, rtol=1e-6)


def test_a_gap_between_two_ends_in_view_counts():
    border = np.full(STRETCHES, 3.0)
    border[6:9] = -5.0
    np.testing.assert_allclose(summed_with_cover(border, border), [39.0 - 15.0] * 2)


def test_a_cover_ends_both_borders_at_one_place():
    left, right = with_covered(3.0, -5.0, 6), np.full(STRETCHES, 3.0)
    np.testing.assert_allclose(summed_with_cover(left, right), [30.0 - COST / 2, 30.0 - COST / 2])


def test_a_third_of_what_is_in_view_is_left():
    border = with_covered(3.0, -5.0, STRETCHES - 2)
    covered = STRETCHES - -(-STRETCHES // SHOWN_PART)
    left_over = border[covered:].sum()
    np.testing.assert_allclose(summed_with_cover(border, border), [left_over - COST / 2] * 2)


def test_a_short_cable_is_nowhere_covered():
    border = np.zeros(STRETCHES)
    border[5:8] = (-9.0, -9.0, 4.0)
    np.testing.assert_allclose(summed_with_cover(border, border), [-14.0, -14.0])


@given(SEEDS, st.floats(0.0, 40.0))
def test_a_covered_end_is_one_for_which_the_sum_is_the_largest(seed, cost):
    left, right = np.random.default_rng(seed).normal(0.0, 10.0, (2, STRETCHES)).astype(np.float32)
    both = left + right
    best = both.sum()
    for count in range(1, STRETCHES - -(-STRETCHES // SHOWN_PART) + 1):
        best = max(best, both[count:].sum() - cost, both[:-count].sum() - cost)
    assert summed_with_cover(left, right, cost).sum() == pytest.approx(best, abs=1e-3)
