"""Shares of useful, wrong and silent frames over thresholds."""

from dataclasses import replace

import pytest

from cable_tracker.cable.parameters.presets import preset
from cable_tracker.evaluation.experiments.roc_experiment import (
    THRESHOLDS,
    RocExperiment,
    claim_shares,
)
from cable_tracker.evaluation.run_metrics import run_metrics
from cable_tracker.evaluation.runs import RunResult, Start


def result(trace) -> RunResult:
    metrics = run_metrics(trace, started_at_random=True)
    return RunResult("default", "world", 0, Start.RANDOM, trace, metrics, b"")


def test_shares_are_taken_over_the_frames_of_all_runs(trace):
    shares = claim_shares([result(trace("hhl")), result(trace("s")), result(trace("ffnn"))])
    assert shares[:4] == pytest.approx((50.0, 25.0, 25.0, 50.0))
    assert shares[4:] == pytest.approx((50.0, 0.0))


def test_thresholds_are_values_that_the_tracker_takes():
    assert len({threshold.filter().name for threshold in THRESHOLDS}) == len(THRESHOLDS)


def test_the_table_says_what_changes_with_each_threshold(trace):
    results = [replace(result(trace("hhs")), method=each.name) for each in THRESHOLDS]
    (table,) = RocExperiment((0,), sequences=()).result_of(results).tables
    told = " ".join(table.notes)
    assert "wrongly claimed [%]" in table.headings
    assert "wrongly claimed and silent are shares of the frames with a visible cable" in told
    usual = preset("default").as_mapping()
    for threshold in THRESHOLDS:
        values = threshold.filter().parameters.as_mapping()
        assert all(f"`{name}`" in told for name in values if values[name] != usual[name])
