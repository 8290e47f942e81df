import pytest

from cable_tracker.evaluation.metric_table import METRIC_TABLE, METRICS_BY_NAME, metric_spread
from cable_tracker.evaluation.metrics.run_metrics import run_metrics
from cable_tracker.evaluation.runs import RunResult, Start


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
