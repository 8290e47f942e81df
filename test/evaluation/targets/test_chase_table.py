import csv
import math

import pytest

from cable_tracker.evaluation.targets.chase_table import (
    PLOT,
    SUMMARY,
    TABLE,
    ChaseRow,
    summarise_chase,
    write_chase,
)


def row(time, distance=2.5, visible=True, claimed=True, told=2.6):
    return ChaseRow(time, distance, visible, claimed, told if claimed else math.nan, 0.1, 0.1)


ROWS = [
    *(row(number) for number in range(10)),
    *(row(number, visible=False, claimed=number == 10) for number in range(10, 14)),
    *(row(number, distance=4.0, claimed=number > 15) for number in range(14, 20)),
]


def test_figures_are_those_of_the_frames():
    summary = summarise_chase(ROWS, 2.5)
    assert summary.frames == 20
    assert summary.seconds == 19
    assert summary.kept == pytest.approx(14 / 20)
    assert summary.claimed_in_view == pytest.approx(14 / 16)
    assert summary.claimed_while_absent == pytest.approx(1 / 4)
    assert (summary.times_hidden, summary.times_found_again) == (1, 1)
    assert summary.range_error == pytest.approx(0.04)
    assert summary.within_two_sigmas == pytest.approx(10 / 14)


def test_a_target_that_is_claimed_too_late_is_not_found_again():
    late = [*ROWS[:14], *(row(number, claimed=number > 17) for number in range(14, 20))]
    assert summarise_chase(late, 2.5).times_found_again == 0


def test_a_target_that_is_out_of_view_at_first_was_not_lost_before():
    late = [row(-1, visible=False, claimed=False), *ROWS]
    summary = summarise_chase(late, 2.5)
    assert (summary.times_hidden, summary.times_found_again) == (1, 1)


def test_table_figures_and_plot_are_written(tmp_path):
    write_chase(tmp_path, ROWS, summarise_chase(ROWS, 2.5))
    assert {path.name for path in tmp_path.iterdir()} == {TABLE, SUMMARY, PLOT}
    with (tmp_path / TABLE).open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == 20
    assert (lines[10]["range"], lines[11]["range"]) == ("2.60000", "")
    assert (lines[11]["is_visible"], lines[14]["is_visible"]) == ("false", "true")
