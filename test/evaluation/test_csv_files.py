import csv
import io

import pytest

from cable_tracker.evaluation.csv_files import CSV_FILES, frames_csv, runs_csv, summary_csv
from cable_tracker.evaluation.metric_table import METRIC_TABLE
from cable_tracker.evaluation.runs import chosen, methods_of, sequences_of


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_runs_are_chosen_by_sequence_and_method(results):
    assert sequences_of(results) == ["stripe", "<other> & more"]
    assert methods_of(results) == ["default", "thesis"]
    assert len(chosen(results)) == 8
    assert len(chosen(results, sequence="stripe")) == 4
    assert len(chosen(results, sequence="stripe", method="thesis")) == 2


def test_there_is_one_row_for_each_run(results):
    table = rows(runs_csv(results))
    assert len(table) == len(results)
    assert float(table[0]["lost [%]"]) == pytest.approx(results[0].metrics["lost"], 1e-5)
    assert table[0]["false_tracking [%]"] == ""


def test_the_summary_has_every_number_of_every_method_and_sequence(results):
    table = rows(summary_csv(results))
    assert len(table) == 2 * 2 * len(METRIC_TABLE)
    frames = next(row for row in table if row["metric"] == "frames")
    assert (frames["runs"], frames["mean"], frames["standard_error"]) == ("2", "12", "0")


def test_there_is_one_row_for_each_frame(results):
    table = rows(frames_csv(results))
    assert len(table) == 8 * 12
    assert table[0]["stamp [s]"] == "1.000000000"
    assert float(table[0]["true_w [px]"]) == 40.0
    assert table[0]["lost"] in ("0", "1")


def test_no_table_holds_nan(results):
    assert not any("nan" in make(results) for _, make in CSV_FILES)
