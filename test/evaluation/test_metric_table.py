import math

import pytest

from cable_tracker.evaluation.metric_table import METRIC_TABLE, METRICS_BY_NAME, metric_spread
from cable_tracker.evaluation.metrics.run_metrics import run_metrics
from cable_tracker.evaluation.runs import RunResult, Start
from cable_tracker.evaluation.trace import trace_of


def test_names_are_unique():
    assert len(METRICS_BY_NAME) == len(METRIC_TABLE)


def test_every_number_can_be_read_of_every_run(trace):
    for letters in ("hlsx", "nf", "u"):
        metrics = run_metrics(trace(letters), started_at_random=True)
        assert all(isinstance(spec.read(metrics), float) for spec in METRIC_TABLE)


@pytest.mark.parametrize(
    ("name", "value"),
    [
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
def test_numbers_are_in_their_units(trace, name, value):
    metrics = run_metrics(trace("shll"), started_at_random=True)
    assert METRICS_BY_NAME[name].read(metrics) == pytest.approx(value)


def test_a_return_is_a_share_in_per_cent(trace):
    metrics = run_metrics(trace("hhnn" + "ss" + "h" * 30), started_at_random=False)
    values = [METRICS_BY_NAME[n].read(metrics) for n in ("returns", "found_again", "time_to_find")]
    assert values == pytest.approx([1.0, 100.0, 0.08])


def test_angles_are_in_degrees(outcome):
    run = trace_of([outcome(0, error=(2.0, math.radians(1.0), 3.0, math.radians(-0.5)))])
    metrics = run_metrics(run, started_at_random=False)
    values = [METRICS_BY_NAME[f"bias_{axis}"].read(metrics) for axis in ("d", "alpha", "w", "beta")]
    assert values == pytest.approx([2.0, 1.0, 3.0, -0.5])


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
