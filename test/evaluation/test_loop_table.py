from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.loop_table import (
    RIGHT_TURNED,
    RIGHT_WITHIN,
    LoopOutcome,
    LoopRow,
    LoopSummary,
    read_summary,
    summarise_loop,
    totals_by_method,
    write_methods,
    write_runs,
)
from cable_tracker.sequences.tables.csv_tables import write_records
from cable_tracker.simulation.rendering.laid_cable import Stretch

LENGTH = 20.0
BURIAL = Stretch(9.0, 11.0)

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


def row(x: float, error: float = 0.1, mode: str = "FOLLOWING", **changes: float) -> LoopRow:
    is_seen = mode == "FOLLOWING"
    values = {
        "time": 2.0 * x,
        "x": x,
        "y": 0.0,
        "altitude": 2.0,
        "yaw": 0.0,
        "speed": 0.5,
        "status": "TRACKING" if is_seen else "LOST",
        "mode": mode,
        "error": error,
        "heading": 0.0,
        "offset": error,
        "measured_offset": error + 0.01 if is_seen else math.nan,
        "measured_heading": 0.0 if is_seen else math.nan,
        "sigma_offset": 0.02 if is_seen else math.nan,
    }
    return LoopRow(**{**values, **changes})


def way(mode_in_the_sand: str = "SEARCHING", error_in_the_sand: float = 0.4) -> list[LoopRow]:
    rows = []
    for step in range(41):
        x = 0.5 * step
        hidden = BURIAL.start <= x <= BURIAL.end
        rows.append(row(x, error_in_the_sand, mode_in_the_sand) if hidden else row(x))
    return rows


def judged(rows: list[LoopRow], burial: Stretch | None = BURIAL) -> LoopSummary:
    return summarise_loop(rows, 7, LENGTH, burial)


def test_a_run_to_the_end_is_not_lost():
    summary = judged(way())
    assert (summary.seed, summary.frames, summary.way) == (7, 41, 20.0)
    assert summary.reached_end and summary.found_again and not summary.lost_for_good
    assert summary.losses == 1
    assert summary.longest_loss == pytest.approx(5.0)


def test_errors_in_the_sand_count_but_not_as_in_sight():
    summary = judged(way())
    assert summary.rms_in_sight == pytest.approx(0.1)
    assert summary.rms > 0.15
    assert summary.most == pytest.approx(0.4)
    assert not summary.is_within_goal
    assert judged(way(error_in_the_sand=0.1)).is_within_goal


def test_the_way_from_where_the_vehicle_was_let_down_does_not_count():
    rows = [row(each.x, 3.0) if each.x < 5.0 else each for each in way(error_in_the_sand=0.1)]
    assert judged(rows).rms == pytest.approx(0.1)


def test_what_is_not_found_after_the_sand_is_lost_for_good():
    rows = [each for each in way() if each.x <= BURIAL.end]
    rows += [row(BURIAL.end + 0.1 * k, 2.0, "GIVEN UP") for k in range(1, 30)]
    summary = judged(rows)
    assert summary.lost_for_good
    assert not summary.found_again and not summary.reached_end


def test_who_drifts_past_the_end_without_the_cable_has_lost_it():
    rows = [row(each.x, 2.0, "SEARCHING") if each.x > 12.0 else each for each in way()]
    assert judged(rows).reached_end
    assert judged(rows).lost_for_good


@pytest.mark.parametrize(
    "something_else",
    [
        {"measured_offset": 0.1 + 2 * RIGHT_WITHIN},
        {"measured_heading": -2 * RIGHT_TURNED},
    ],
)
def test_following_something_else_is_wrong(something_else):
    rows = [replace(each, **something_else) if each.x > 12.0 else each for each in way()]
    summary = judged(rows)
    assert summary.wrong == pytest.approx(16 / 41)
    assert summary.rms_offset == pytest.approx(0.01)
    assert summary.lost_for_good


def test_a_heading_is_that_of_a_line_without_a_sense():
    across = {"heading": math.radians(91.0), "measured_heading": math.radians(-88.0)}
    summary = judged([replace(each, **across) for each in way("FOLLOWING", 0.1)])
    assert summary.wrong == 0.0
    assert summary.rms_heading == pytest.approx(1.0)


def test_waiting_at_the_start_is_no_loss():
    rows = [replace(each, mode="WAITING") if each.x < 2.0 else each for each in way("FOLLOWING")]
    assert judged(rows).losses == 0


def test_without_sand_there_is_nothing_to_find_again():
    assert judged(way("FOLLOWING"), None).found_again


def read(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_tables_are_written_with_gaps_where_nothing_is_known(tmp_path):
    rows = way()
    write_records(tmp_path / "rows.csv", LoopRow, rows)
    write_records(tmp_path / "summary.csv", LoopSummary, [judged(rows)])
    table = read(tmp_path / "rows.csv")
    assert len(table) == len(rows)
    assert float(table[3]["x"]) == 1.5
    assert table[20]["measured_offset"] == "" and table[20]["mode"] == "SEARCHING"
    (summary,) = read(tmp_path / "summary.csv")
    assert summary["seed"] == "7"
    assert summary["lost_for_good"] == "false"


def test_a_summary_is_read_as_it_was_written(tmp_path):
    written = replace(judged(way()), rms=0.12345, rms_offset=math.nan)
    write_records(tmp_path / "summary.csv", LoopSummary, [written])
    read_back = read_summary(tmp_path / "summary.csv")
    assert (read_back.rms, read_back.losses, read_back.found_again) == (0.12345, 1, True)
    assert math.isnan(read_back.rms_offset)


@pytest.mark.parametrize("content", ["", "seed\n1\n", None])
def test_what_is_no_summary_is_refused(tmp_path, content):
    path = tmp_path / "summary.csv"
    if content is not None:
        path.write_text(content, encoding="utf-8")
    with pytest.raises(RecordingError, match="no summary of a closed loop"):
        read_summary(path)


def test_frames_without_an_answer_are_counted():
    rows = [replace(each, status="") if each.x < 5.0 else each for each in way()]
    assert judged(rows).answered == pytest.approx(31 / 41)


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
