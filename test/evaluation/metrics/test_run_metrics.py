import math

import pytest

from cable_tracker.evaluation.metrics.run_metrics import run_metrics
from cable_tracker.evaluation.trace import trace_of


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
