"""Memory grows with a dive by what its rows take, and by little else."""

import tracemalloc

from survey_dives import Plan, make_dive

from cable_tracker.survey.frame_table import ROW, FrameTable
from cable_tracker.survey.outputs.frames import write_frames
from cable_tracker.survey.recording import SurveySettings, analyse

MOST_BYTES = 1500
"""For each tracked picture while a dive is smoothed and written. These dives are shorter than the
blocks in which much is done, so that all of it grows with them."""


def peak_of(dive, path) -> int:
    tracemalloc.start()
    _, course = analyse(dive, SurveySettings())
    write_frames(path, "dive", dive, course)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def test_a_longer_dive_takes_little_more_memory(tmp_path):
    short, long = (make_dive(Plan(length=length)) for length in (20.0, 120.0))
    peak_of(short, tmp_path / "short.parquet")  # What is compiled and imported stays.
    more = peak_of(long, tmp_path / "long.parquet") - peak_of(short, tmp_path / "short.parquet")
    assert more < MOST_BYTES * (len(long.table) - len(short.table))


def test_a_row_is_small():
    assert ROW.itemsize <= 144


def test_rows_are_kept_over_many_blocks():
    table = FrameTable()
    for number in range(10_000):
        table.append()["frame"] = number
        if number in {17, 5000}:
            assert len(table.rows) == number + 1
    assert len(table) == 10_000
    assert (table.rows["frame"] == range(10_000)).all()
