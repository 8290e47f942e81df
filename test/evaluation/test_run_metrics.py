import math

import numpy as np
import pytest

from cable_tracker.evaluation.run_metrics import (
    METRIC_TABLE,
    METRICS_BY_NAME,
    StartOutcome,
    loss_episodes,
    return_times,
    run_metrics,
    start_statistics,
)
from cable_tracker.evaluation.runs import RunResult, Start, metric_spread
from cable_tracker.evaluation.trace import trace_of


@pytest.fixture
def measured(trace):
    """Measure a run of letters, see `trace`, that had to find the cable by itself."""
    return lambda letters: run_metrics(trace(letters), started_at_random=True)


@pytest.mark.parametrize("letters", ["hlsx", "nf", "u"])
def test_every_run_has_every_number_of_the_table(trace, letters):
    for at_random in (False, True):
        metrics = run_metrics(trace(letters), started_at_random=at_random)
        assert metrics.keys() == {spec.name for spec in METRIC_TABLE}
        assert all(isinstance(value, float) for value in metrics.values())


def test_a_start_from_the_truth_is_not_judged(trace):
    assert math.isnan(run_metrics(trace("hh"), started_at_random=False)["start_right"])
    assert run_metrics(trace("hh"), started_at_random=True)["start_right"] == 100.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("frames", 4.0),
        ("visible", 4.0),
        ("lost", 75.0),
        ("useful", 25.0),
        ("silence", 25.0),
        ("wrong_claims", 200 / 3),
        ("longest_loss", 0.08),
        ("start_right", 100.0),
        ("start_wrong", 0.0),
        ("frames_to_right", 2.0),
        ("ms", 5.0),
    ],
)
def test_numbers_are_in_their_units(measured, name, value):
    assert measured("shll")[name] == pytest.approx(value)


def test_angles_are_in_degrees(outcome):
    run = trace_of([outcome(0, error=(2.0, math.radians(1.0), 3.0, math.radians(-0.5)))])
    metrics = run_metrics(run, started_at_random=False)
    values = [metrics[f"bias_{axis}"] for axis in ("d", "alpha", "w", "beta")]
    assert values == pytest.approx([2.0, 1.0, 3.0, -0.5])


def test_held_errors_leave_out_what_is_lost(measured):
    metrics = measured("hhl")
    assert metrics["held_rmse_d"] == pytest.approx(0.0)
    assert metrics["rmse_d"] == pytest.approx(50.0 / math.sqrt(3))


def test_times_are_summarised_by_median_and_95th_percentile(outcome):
    run = trace_of([outcome(i, ms=float(i)) for i in range(101)])
    metrics = run_metrics(run, started_at_random=False)
    assert (metrics["ms"], metrics["ms_p95"]) == (50.0, 95.0)


def test_claims_by_hand(measured):
    metrics = measured("hhlsxffnu")
    assert metrics["silence"] == pytest.approx(100 * 2 / 5)
    assert metrics["wrong_claims"] == pytest.approx(100 * 1 / 3)
    assert metrics["false_tracking"] == pytest.approx(100 * 2 / 3)
    assert metrics["useful"] == pytest.approx(100 * 2 / 5)


@pytest.mark.parametrize("letters", ["hlsx", "h", "sx", "lll", "hhlss"])
def test_silence_wrong_claims_and_useful_frames_are_all_there_is(measured, letters):
    metrics = measured(letters)
    useful, silence = metrics["useful"], metrics["silence"]
    wrong = 0.0 if silence == 100.0 else metrics["wrong_claims"] * (1.0 - silence / 100.0)
    assert useful + silence + wrong == pytest.approx(100.0)
    assert metrics["lost"] == pytest.approx(100.0 - useful)


def test_losses_end_with_recovery_or_with_the_cable(trace):
    recovered, departed, final = loss_episodes(trace("hllhxnnhl"))
    assert (recovered.frame_count, recovered.recovered) == (2, True)
    assert recovered.seconds == pytest.approx(0.08)
    assert (departed.frame_count, departed.recovered) == (1, False)
    assert (final.frame_count, final.recovered) == (1, False)
    assert final.seconds == pytest.approx(0.04)


def test_frames_without_a_label_do_not_interrupt_a_loss(trace):
    (loss,) = loss_episodes(trace("hlulh"))
    assert loss.frame_count == 2
    assert loss.seconds == pytest.approx(0.12)


def test_a_loss_ends_with_its_recording(trace, apart):
    first, second = loss_episodes(apart(trace("hll"), trace("lh")))
    assert (first.frame_count, first.recovered) == (2, False)
    assert first.seconds == pytest.approx(0.08)
    assert (second.frame_count, second.recovered) == (1, True)
    assert second.seconds == pytest.approx(0.04)


def test_losses_by_hand(measured):
    metrics = measured("hllhlnnhlllh")
    assert metrics["lost"] == pytest.approx(100 * 6 / 10)
    assert metrics["longest_loss_frames"] == 3
    assert metrics["longest_loss"] == pytest.approx(0.12)
    assert metrics["recovery"] == pytest.approx((0.08 + 0.12) / 2)
    assert metrics["unrecovered"] == 1


def test_without_a_loss_there_is_no_time_to_recover(measured):
    metrics = measured("hhh")
    names = ("lost", "longest_loss_frames", "longest_loss", "unrecovered")
    assert [metrics[name] for name in names] == [0.0, 0.0, 0.0, 0.0]
    assert math.isnan(metrics["recovery"])


def test_without_a_cable_nothing_can_be_lost(measured):
    metrics = measured("fnn")
    names = ("lost", "longest_loss_frames", "longest_loss", "recovery", "unrecovered")
    assert all(math.isnan(metrics[name]) for name in names)


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
    assert return_times(run) == pytest.approx([0.08])


@pytest.mark.parametrize(("silent", "found"), [(0, 100.0), (25, 100.0), (26, 0.0)])
def test_a_cable_is_found_again_within_a_second(outcome, silent, found):
    run = shown(outcome, (3, 0.9, True), (5, 0.0, False), (silent, 0.9, False), (30, 0.9, True))
    metrics = run_metrics(run, started_at_random=False)
    assert (metrics["returns"], metrics["found_again"]) == (1.0, found)
    time = silent * 0.04 if found else math.nan
    assert metrics["time_to_find"] == pytest.approx(time, nan_ok=True)


def test_a_cable_does_not_come_back_in_another_recording(trace, apart):
    assert return_times(apart(trace("hhnn"), trace("s" * 30))) == []
    assert return_times(apart(trace("hhnn" + "s" * 10), trace("s" * 30))) == []
    assert return_times(apart(trace("hh"), trace("hhnn" + "h" * 30))) == [0.0]


def test_a_wrong_claim_finds_nothing(measured):
    assert measured("hhnn" + "l" * 30)["found_again"] == 0.0


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
def test_without_a_full_return_nothing_is_found_again(measured, letters):
    metrics = measured(letters)
    assert metrics["returns"] == 0.0
    assert math.isnan(metrics["found_again"])


def test_every_return_counts(measured):
    metrics = measured("hhnn" + "h" * 30 + "n" + "s" * 30)
    values = [metrics[name] for name in ("returns", "found_again", "time_to_find")]
    assert values == [2.0, 50.0, 0.0]


def test_inside_two_sigma_by_hand(outcome):
    errors = [(0.0, 0.0, 0.0, 0.0), (3.9, 0.05, 0.0, 0.0), (4.1, 0.0, 0.0, 0.03)]
    run = trace_of([outcome(i, error=error) for i, error in enumerate(errors)])
    metrics = run_metrics(run, started_at_random=False)
    inside = [metrics[f"inside_2_sigma_{axis}"] for axis in ("d", "alpha", "w", "beta")]
    assert inside == pytest.approx([200 / 3, 200 / 3, 100.0, 200 / 3])


def test_only_claims_must_be_consistent(measured):
    metrics = measured("sxn")
    names = ("nees_mean", "nees_median", "inside_region", "inside_2_sigma_d")
    assert np.isnan([metrics[name] for name in names]).all()


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


def test_names_are_unique():
    assert len(METRICS_BY_NAME) == len(METRIC_TABLE)


def test_a_spread_is_taken_over_runs(trace):
    runs = []
    for seed, letters in enumerate(("hh", "hl")):
        frames = trace(letters)
        metrics = run_metrics(frames, started_at_random=False)
        runs.append(RunResult("default", "world", seed, Start.TRUTH, frames, metrics, b""))
    spread = metric_spread("lost", runs)
    assert (spread.mean, spread.minimum, spread.maximum) == (25.0, 0.0, 50.0)


@pytest.mark.parametrize(
    ("name", "heading", "title"),
    [
        ("lost", "lost [%]", "frames lost [%]"),
        ("nees_median", "nees_median", "median NEES"),
    ],
)
def test_a_unit_is_given_only_where_there_is_one(name, heading, title):
    spec = METRICS_BY_NAME[name]
    assert (spec.heading, spec.title) == (heading, title)
