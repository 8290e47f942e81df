import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.metrics import (
    StartOutcome,
    cable_returns,
    claim_statistics,
    consistency_statistics,
    coverage,
    error_statistics,
    loss_episodes,
    loss_statistics,
    nees,
    return_statistics,
    run_metrics,
    start_statistics,
    state_errors,
    summarise_errors,
)
from cable_tracker.evaluation.trace import trace_of
from cable_tracker.sequences.estimates import EstimateRow


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


def test_losses_end_with_recovery_or_with_the_cable(trace):
    recovered, departed, final = loss_episodes(trace("hllhxnnhl"))
    assert (recovered.start, recovered.frame_count, recovered.recovered) == (1, 2, True)
    assert recovered.seconds == pytest.approx(0.08)
    assert (departed.start, departed.frame_count, departed.recovered) == (4, 1, False)
    assert (final.start, final.frame_count, final.recovered) == (8, 1, False)
    assert final.seconds == pytest.approx(0.04)


def test_frames_that_nobody_knows_do_not_interrupt_a_loss(trace):
    (loss,) = loss_episodes(trace("hlulh"))
    assert loss.frame_count == 2
    assert loss.seconds == pytest.approx(0.12)


def test_loss_statistics_by_hand(trace):
    loss = loss_statistics(trace("hllhlnnhlllh"))
    assert loss.share == pytest.approx(6 / 10)
    assert loss.longest_frames == 3
    assert loss.longest_seconds == pytest.approx(0.12)
    assert loss.recovery_seconds == pytest.approx((0.08 + 0.12) / 2)
    assert loss.unrecovered == 1


def test_without_a_loss_there_is_no_time_to_recover(trace):
    loss = loss_statistics(trace("hhh"))
    assert (loss.share, loss.longest_frames, loss.unrecovered) == (0.0, 0.0, 0.0)
    assert math.isnan(loss.recovery_seconds)


def test_without_a_cable_nothing_can_be_lost(trace):
    assert math.isnan(loss_statistics(trace("fnn")).share)


def test_claims_by_hand(trace):
    claims = claim_statistics(trace("hhlsxffnu"))
    assert claims.silence == pytest.approx(2 / 5)
    assert claims.wrong_claims == pytest.approx(1 / 3)
    assert claims.false_tracking == pytest.approx(2 / 3)


def test_nees_by_hand():
    covariance = np.array([[4.0, 1.0], [1.0, 1.0]])
    # Inverse: [[1, -1], [-1, 4]] / 3.
    squares = nees(np.array([[1.0, 1.0], [0.0, 0.0]]), np.stack((covariance, covariance)))
    assert squares == pytest.approx([1.0, 0.0])


def test_nees_of_a_singular_covariance_is_infinite():
    assert nees(np.ones((2, 2)), np.stack((np.ones((2, 2)), np.zeros((2, 2))))).tolist() == [
        math.inf,
        math.inf,
    ]


def test_nees_of_honest_errors_is_their_number_of_dimensions():
    rng = np.random.default_rng(0)
    factor = np.array([[3.0, 0, 0, 0], [0.01, 0.02, 0, 0], [1, 0, 2, 0], [0, 0, 0.004, 0.01]])
    errors = rng.standard_normal((4000, 4)) @ factor.T
    squares = nees(errors, np.tile(factor @ factor.T, (4000, 1, 1)))
    assert squares.mean() == pytest.approx(4.0, rel=0.05)
    assert np.median(squares) == pytest.approx(3.357, rel=0.05)


def test_inside_two_sigma_by_hand(outcome):
    errors = [(0.0, 0.0, 0.0, 0.0), (3.9, 0.05, 0.0, 0.0), (4.1, 0.0, 0.0, 0.03)]
    statistics = consistency_statistics(
        trace_of([outcome(i, error=error) for i, error in enumerate(errors)])
    )
    assert statistics.inside == pytest.approx([2 / 3, 2 / 3, 1.0, 2 / 3])


def test_only_claims_must_be_consistent(trace):
    assert math.isnan(consistency_statistics(trace("sxn")).nees_mean)


def test_coverage_of_honest_errors_is_nominal(outcome):
    rng = np.random.default_rng(1)
    sigma = np.array((2.0, 0.02, 3.0, 0.01))
    truth = CableState(0.0, 0.0, 60.0)
    outcomes = [outcome(i, truth, tuple(rng.standard_normal(4) * sigma)) for i in range(1500)]
    nominal = np.array([0.2, 0.5, 0.9])
    shares = coverage([trace_of(outcomes)], nominal)
    assert shares == pytest.approx(np.tile(nominal[:, None], (1, 4)), abs=0.04)


def test_coverage_of_nothing_is_unknown(trace):
    assert np.isnan(coverage([trace("ss")], np.array([0.5]))).all()


@pytest.mark.parametrize(
    ("letters", "outcome", "frames"),
    [
        ("sshh", StartOutcome.RIGHT, 3),
        ("sslh", StartOutcome.RIGHT, 4),
        ("sl" + "x" * 28 + "h", StartOutcome.WRONG, 31),
        ("nnnhh", StartOutcome.RIGHT, 1),
        ("s" * 30 + "h", StartOutcome.NONE, 31),
        ("s" * 29 + "h", StartOutcome.RIGHT, 30),
        ("nn", None, math.nan),
    ],
)
def test_a_start_is_right_if_the_cable_is_claimed_within_30_frames_that_show_it(
    trace, letters, outcome, frames
):
    start = start_statistics(trace(letters))
    assert start.outcome is outcome
    assert start.frames_to_right == pytest.approx(frames, nan_ok=True)


def test_a_start_is_as_clear_as_the_frames_that_it_is_judged_by(outcome):
    shares = [0.0, 0.0, *[0.4, 0.8] * 15, *[1.0] * 5]
    run = trace_of([outcome(i, visibility=share) for i, share in enumerate(shares)])
    assert start_statistics(run).visibility == pytest.approx(0.6)


def shown(outcome, *pieces):
    """Make a run of pieces: number of frames, visibility, whether the cable is claimed rightly."""
    frames = [(share, right) for count, share, right in pieces for _ in range(count)]
    return trace_of(
        [outcome(i, visibility=share, claimed=right) for i, (share, right) in enumerate(frames)]
    )


def test_a_return_counts_from_when_the_cable_clearly_shows(outcome):
    run = shown(
        outcome, (3, 0.9, True), (5, 0.0, False), (4, 0.2, False), (2, 0.3, False), (40, 0.9, True)
    )
    (back,) = cable_returns(run)
    assert back.start == 12
    assert back.seconds == pytest.approx(0.08)


@pytest.mark.parametrize(("silent", "found"), [(0, 1.0), (25, 1.0), (26, 0.0)])
def test_a_cable_is_found_again_within_a_second(outcome, silent, found):
    run = shown(outcome, (3, 0.9, True), (5, 0.0, False), (silent, 0.9, False), (30, 0.9, True))
    returns = return_statistics(run)
    assert (returns.count, returns.found) == (1.0, found)
    assert returns.seconds == pytest.approx(silent * 0.04 if found else math.nan, nan_ok=True)


def test_a_wrong_claim_finds_nothing(trace):
    assert return_statistics(trace("hhnn" + "l" * 30)).found == 0.0


@pytest.mark.parametrize(
    "letters",
    [
        "h" * 60,
        "n" * 10 + "h" * 60,
        "hhnn" + "h" * 25,
        "hhnn" + "s" * 10 + "n" * 30,
        "nnff",
    ],
    ids=["never away", "never seen before", "run ends", "leaves again", "no cable"],
)
def test_without_a_full_return_nothing_is_found_again(trace, letters):
    returns = return_statistics(trace(letters))
    assert returns.count == 0.0
    assert math.isnan(returns.found)


def test_every_return_counts(trace):
    returns = return_statistics(trace("hhnn" + "h" * 30 + "n" + "s" * 30))
    assert (returns.count, returns.found, returns.seconds) == (2.0, 0.5, 0.0)


def test_a_start_from_the_truth_is_not_judged(trace):
    assert run_metrics(trace("hh"), started_at_random=False).start is None
    assert run_metrics(trace("hh"), started_at_random=True).start is not None


def test_held_errors_leave_out_what_is_lost(trace):
    metrics = run_metrics(trace("hhl"), started_at_random=False)
    assert metrics.held_errors.rmse[0] == pytest.approx(0.0)
    assert metrics.errors.rmse[0] == pytest.approx(50.0 / math.sqrt(3))
    assert (metrics.frame_count, metrics.visible_count) == (3, 3)


def test_times_are_summarised_by_median_and_95th_percentile(outcome):
    run = trace_of([outcome(i, ms=float(i)) for i in range(101)])
    metrics = run_metrics(run, started_at_random=False)
    assert (metrics.ms_median, metrics.ms_95) == (50.0, 95.0)


def test_state_errors_see_one_line_written_in_two_ways():
    truth, same = CableState(5.0, 1.55, 20.0, 0.1), CableState(-5.0, 1.55 - math.pi, 20.0, -0.1)
    assert state_errors(same, truth) == pytest.approx([0, 0, 0, 0], abs=1e-12)


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
    assert summary.bias[0] == pytest.approx(7.0)
