from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest

from cable_tracker.evaluation.closed_loop.loop_campaign import (
    LoopOutcome,
    totals_by_method,
    write_methods,
    write_runs,
)
from cable_tracker.evaluation.closed_loop.loop_table import LoopSummary

GOOD = LoopSummary(
    seed=1, frames=100, seconds=8.0, way=100.0, reached_end=True, rms=0.06, percentile_95=0.1,
    most=0.3, rms_in_sight=0.04, rms_offset=0.01, rms_heading=1.0, answered=1.0, measured=0.9,
    wrong=0.0, losses=1, longest_loss=12.0, found_again=True, lost_for_good=False,
)  # fmt: skip
WIDE = replace(GOOD, seed=2, rms=0.2, most=0.9)
LOST = replace(
    GOOD, seed=3, way=50.0, rms=2.0, most=7.0, rms_offset=math.nan, found_again=False,
    lost_for_good=True,
)  # fmt: skip

OUTCOMES = (
    LoopOutcome("hough", 1, GOOD),
    LoopOutcome("default", 1, GOOD),
    LoopOutcome("hough", 2, WIDE),
    LoopOutcome("hough", 3, LOST),
    LoopOutcome("hough", 4, None, "the tracker node has died: out of memory"),
)


def read(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_methods_come_in_the_order_in_which_they_appear():
    assert [each["method"] for each in totals_by_method(OUTCOMES)] == ["hough", "default"]


def test_every_run_counts_also_one_that_failed():
    hough, _ = totals_by_method(OUTCOMES)
    assert (hough["runs"], hough["failed"]) == (4, 1)
    assert (hough["kept"], hough["found_again"], hough["within_goal"]) == (2, 2, 1)


def test_medians_do_not_hide_the_worst():
    hough, _ = totals_by_method(OUTCOMES)
    assert (hough["rms"], hough["worst_rms"], hough["most"]) == (0.2, 2.0, 7.0)
    assert hough["way"] == 100.0


def test_what_a_run_does_not_know_does_not_count():
    hough, _ = totals_by_method(OUTCOMES)
    assert hough["rms_offset"] == pytest.approx(0.01)


def test_without_a_run_that_ended_nothing_is_known():
    (totals,) = totals_by_method(OUTCOMES[-1:])
    assert (totals["runs"], totals["failed"], totals["kept"]) == (1, 1, 0)
    assert math.isnan(totals["rms"])


def test_the_table_of_runs_says_why_one_failed(tmp_path):
    write_runs(tmp_path / "runs.csv", OUTCOMES)
    rows = read(tmp_path / "runs.csv")
    assert [row["method"] for row in rows] == [each.method for each in OUTCOMES]
    assert (rows[2]["rms"], rows[2]["failure"]) == ("0.20000", "")
    assert rows[-1]["failure"] == "the tracker node has died: out of memory"
    assert rows[-1]["rms"] == rows[-1]["lost_for_good"] == ""


def test_the_table_of_methods_has_gaps_where_nothing_is_known(tmp_path):
    write_methods(tmp_path / "methods.csv", totals_by_method(OUTCOMES[-1:]))
    (row,) = read(tmp_path / "methods.csv")
    assert (row["method"], row["failed"], row["rms"]) == ("hough", "1", "")
