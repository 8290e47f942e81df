import dataclasses
import math

from cable_tracker.benchmark.cases import Accuracy
from cable_tracker.benchmark.report import (
    check_page,
    result_markdown,
    tables_of,
    write_page,
)
from cable_tracker.benchmark.result import BenchmarkResult, Circumstances
from cable_tracker.benchmark.round_robin import CaseLabel, Measurement
from cable_tracker.benchmark.statistics import Quartiles

SPREAD = Quartiles(0.00012, 1234.5, 0.5, 4)
RESULT = BenchmarkResult(
    Circumstances(
        "bench --quick", "today", "a machine", "numba 1", (1.0,) * 3, (2.0,) * 3, ("filterpy",)
    ),
    (
        Measurement(CaseLabel("frame", "thesis", (320, 240), 500), SPREAD, SPREAD, SPREAD),
        Measurement(
            CaseLabel("frame", "thesis", (1920, 1080), 500), skipped="left out: about 3.0 s"
        ),
    ),
    (), (), (), (),
)  # fmt: skip


def test_only_tables_with_rows_are_shown():
    titles = [table.title for table in tables_of(RESULT)]
    assert titles[0] == "Goals"
    assert not any(title.startswith("Resident memory") for title in titles)
    assert all(len(row) == len(table.headings) for table in tables_of(RESULT) for row in table.rows)


def test_spread_ratio_and_what_was_left_out_are_in_the_grid():
    (grid,) = [table for table in tables_of(RESULT) if table.title.startswith("Whole frames")]
    assert grid.headings[2:] == ("320x240 [ms]", "1920x1080 [ms]")
    assert grid.rows == (("thesis", "500", "1234 (0.00012–0.5) = 1234x", "left out: about 3.0 s"),)


def test_what_is_no_number_is_left_open():
    unknown = Accuracy("thesis", math.nan, math.nan, -math.inf)
    result = dataclasses.replace(RESULT, accuracies=(unknown,))
    (rivals,) = [table for table in tables_of(result) if table.title.startswith("Against")]
    assert rivals.rows[0][3:] == ("–", "–", "−∞")


def test_an_absent_library_is_said_to_be_absent():
    (rivals,) = [table for table in tables_of(RESULT) if table.title.startswith("Against")]
    assert rivals.rows[-1][:2] == ("filterpy", "not installed")


def test_the_page_says_how_it_was_measured():
    text = result_markdown(RESULT)
    assert text.startswith("`bench --quick` on today, a machine. numba 1. One thread")
    assert "| goal | wanted | measured | met |" in text


def test_a_new_page_can_be_written_again(tmp_path):
    page = tmp_path / "page.md"
    for text in ("one\n", "two\n"):
        check_page(page)
        write_page(page, text)
    assert "two" in page.read_text()
    assert "one" not in page.read_text()
