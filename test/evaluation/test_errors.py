from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.errors import (
    error_statistics,
    forgiven_distance,
    is_off_cable,
    state_errors,
    summarise_errors,
)
from cable_tracker.sequences.tables.estimates import EstimateRow

DEGREE = np.pi / 180


def errors(*rows):
    return np.array([(*row, 0.0, 0.0) for row in rows])


def test_ten_pixels_are_forgiven_of_a_thin_cable_and_half_the_width_of_a_wide_one():
    off = errors((9.9, 0.0), (-10.1, 0.0), (14.9, 0.0), (-15.1, 0.0))
    widths = np.array([4.0, 4.0, 30.0, 30.0])
    assert is_off_cable(off, widths, forgiven=forgiven_distance(320)).tolist() == [
        False,
        True,
        False,
        True,
    ]


def test_the_ten_pixels_grow_with_the_image():
    off = errors((39.9, 0.0), (40.1, 0.0))
    assert is_off_cable(off, np.array([4.0, 4.0]), forgiven=forgiven_distance(1280)).tolist() == [
        False,
        True,
    ]


def test_no_pixels_are_forgiven_outside_the_borders():
    off = errors((2.0, 0.0), (-2.1, 0.0), (15.0, 0.0), (-15.1, 0.0))
    widths = np.array([4.0, 4.0, 30.0, 30.0])
    assert is_off_cable(off, widths, forgiven=0.0).tolist() == [False, True, False, True]


@pytest.mark.parametrize("forgiven", [0.0, 10.0])
def test_eight_degrees_are_too_much_and_width_and_taper_do_not_count(forgiven):
    off = np.array([(0.0, 8 * DEGREE, 99.0, 1.0), (0.0, -8.1 * DEGREE, 0.0, 0.0)])
    assert is_off_cable(off, np.array([30.0, 30.0]), forgiven=forgiven).tolist() == [False, True]


@pytest.mark.parametrize("forgiven", [0.0, 10.0])
def test_an_error_that_is_no_number_is_off_the_cable(forgiven):
    assert is_off_cable(errors((math.nan, 0.0)), np.array([30.0]), forgiven=forgiven).all()


def row(frame: int, state: CableState | None) -> EstimateRow:
    return EstimateRow(frame, frame, "TRACKING" if state else "LOST", state=state)


def test_error_statistics_by_hand():
    errors = np.zeros((4, 4))
    errors[:, 0] = (1.0, -1.0, 3.0, -5.0)
    statistics = error_statistics(errors)
    assert statistics.bias[0] == pytest.approx(-0.5)
    assert statistics.rmse[0] == pytest.approx(3.0)  # sqrt((1 + 1 + 9 + 25) / 4)
    assert statistics.median[0] == pytest.approx(2.0)
    assert statistics.percentile_95[0] == pytest.approx(4.7)  # 3 + 0.85 (5 - 3)


def test_error_statistics_of_nothing_are_unknown():
    assert np.isnan(error_statistics(np.zeros((0, 4))).rmse).all()


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=40))
def test_rmse_is_at_least_the_bias_and_not_more_than_the_largest_error(values):
    errors = np.tile(np.array(values)[:, None], (1, 4))
    statistics = error_statistics(errors)
    assert (statistics.rmse >= np.abs(statistics.bias) - 1e-9).all()
    assert (statistics.rmse <= np.abs(errors).max() + 1e-9).all()


def test_errors_are_estimate_minus_truth():
    errors = state_errors(CableState(12.0, 0.3, 28.0, 0.1), CableState(10.0, 0.4, 30.0, 0.05))
    np.testing.assert_allclose(errors, [2.0, -0.1, -2.0, 0.05])


def test_errors_are_taken_across_the_wrap():
    estimate = CableState(-11.0, -89 * DEGREE, 30.0, -0.02)
    truth = CableState(10.0, 89 * DEGREE, 30.0, 0.01)
    np.testing.assert_allclose(
        state_errors(estimate, truth), [1.0, 2 * DEGREE, 0.0, 0.01], atol=1e-12
    )


def test_state_errors_see_one_line_written_in_two_ways():
    truth, same = CableState(5.0, 1.55, 20.0, 0.1), CableState(-5.0, 1.55 - math.pi, 20.0, -0.1)
    assert state_errors(same, truth) == pytest.approx([0, 0, 0, 0], abs=1e-12)


def test_a_summary_worked_by_hand():
    truth = CableState(0.0, 0.0, 30.0, 0.0)
    rows = [
        row(0, CableState(1.0, 0.0, 30.0, 0.0)),
        row(1, CableState(-3.0, 0.1, 33.0, 0.0)),
        row(2, CableState(20.0, 0.0, 30.0, 0.0)),
        row(3, None),
        row(4, CableState(500.0, 0.0, 30.0)),  # Not labelled.
    ]
    truths = {0: truth, 1: truth, 2: truth, 3: truth, 9: truth}
    summary = summarise_errors(rows, truths)
    assert (summary.labelled, summary.claimed) == (5, 3)
    assert summary.share_off == pytest.approx(1 / 3)
    np.testing.assert_allclose(summary.errors.bias, [6.0, 0.1 / 3, 1.0, 0.0])
    np.testing.assert_allclose(
        summary.errors.rmse, [np.sqrt(410 / 3), 0.1 / np.sqrt(3), np.sqrt(3.0), 0.0]
    )
    np.testing.assert_allclose(summary.errors.median, [3.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(summary.errors.percentile_95, [18.3, 0.09, 2.7, 0.0])


def test_a_tracked_table_is_compared_by_frame_number():
    truth = CableState(0.0, 0.0, 20.0)
    rows = [
        EstimateRow(0, 0, "TRACKING", CableState(3.0, 0.0, 20.0)),
        EstimateRow(1, 1, "TRACKING", CableState(11.0, 0.0, 20.0)),
        EstimateRow(2, 2, "LOST"),
        EstimateRow(3, 3, "TRACKING", truth),
    ]
    summary = summarise_errors(rows, {0: truth, 1: truth, 2: truth})
    assert (summary.labelled, summary.claimed, summary.share_off) == (3, 2, 0.5)
    assert summary.errors.bias[0] == pytest.approx(7.0)


@pytest.mark.parametrize(
    ("rows", "truths"), [([], {}), ([row(0, None)], {0: CableState(0.0, 0.0, 1.0)})]
)
def test_without_a_claimed_label_there_are_no_errors(rows, truths):
    summary = summarise_errors(rows, truths)
    assert (summary.labelled, summary.claimed) == (len(truths), 0)
    for numbers in (
        summary.errors.bias,
        summary.errors.rmse,
        summary.errors.median,
        summary.errors.percentile_95,
    ):
        assert np.isnan(numbers).all()
    assert np.isnan(summary.share_off)
