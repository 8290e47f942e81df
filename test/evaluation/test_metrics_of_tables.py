from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.metrics import is_off, state_errors, summarise_errors
from cable_tracker.sequences.estimates import EstimateRow

DEGREE = np.pi / 180


def row(frame: int, state: CableState | None) -> EstimateRow:
    return EstimateRow(frame, frame, "TRACKING" if state else "LOST", state=state)


def test_errors_are_estimate_minus_truth():
    errors = state_errors(CableState(12.0, 0.3, 28.0, 0.1), CableState(10.0, 0.4, 30.0, 0.05))
    np.testing.assert_allclose(errors, [2.0, -0.1, -2.0, 0.05])


def test_errors_are_taken_across_the_wrap():
    estimate = CableState(-11.0, -89 * DEGREE, 30.0, -0.02)
    truth = CableState(10.0, 89 * DEGREE, 30.0, 0.01)
    np.testing.assert_allclose(
        state_errors(estimate, truth), [1.0, 2 * DEGREE, 0.0, 0.01], atol=1e-12
    )


@pytest.mark.parametrize(
    ("errors", "off"),
    [
        ([15.0, 0.0, 0.0, 0.0], False),
        ([-15.1, 0.0, 0.0, 0.0], True),
        ([0.0, 8 * DEGREE, 0.0, 0.0], False),
        ([0.0, -8.1 * DEGREE, 0.0, 0.0], True),
        ([0.0, 0.0, 99.0, 1.0], False),
    ],
)
def test_an_estimate_is_off_by_half_the_width_or_eight_degrees(errors, off):
    assert is_off(np.array(errors), CableState(0.0, 0.0, 30.0)) is off


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
    np.testing.assert_allclose(summary.bias, [6.0, 0.1 / 3, 1.0, 0.0])
    np.testing.assert_allclose(
        summary.rmse, [np.sqrt(410 / 3), 0.1 / np.sqrt(3), np.sqrt(3.0), 0.0]
    )
    np.testing.assert_allclose(summary.median, [3.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(summary.percentile_95, [18.3, 0.09, 2.7, 0.0])


@pytest.mark.parametrize(
    ("rows", "truths"), [([], {}), ([row(0, None)], {0: CableState(0.0, 0.0, 1.0)})]
)
def test_without_a_claimed_label_there_are_no_errors(rows, truths):
    summary = summarise_errors(rows, truths)
    assert (summary.labelled, summary.claimed) == (len(truths), 0)
    for numbers in (summary.bias, summary.rmse, summary.median, summary.percentile_95):
        assert np.isnan(numbers).all()
    assert np.isnan(summary.share_off)
