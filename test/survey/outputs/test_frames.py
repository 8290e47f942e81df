import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from survey_dives import Plan, make_dive

from cable_tracker.survey.frame_table import HIDDEN, SEEN
from cable_tracker.survey.outputs.frames import join_frames, write_frames
from cable_tracker.survey.recording import SurveySettings, analyse


def test_frames_of_several_dives_are_one_table(tmp_path):
    parts = []
    for name in ("a", "b"):
        dive = make_dive(Plan(length=10.0))
        _, course = analyse(dive, SurveySettings())
        parts.append(tmp_path / f"{name}.parquet")
        write_frames(parts[-1], name, dive, course)
    join_frames(parts, tmp_path / "frames.parquet")
    table = pq.read_table(tmp_path / "frames.parquet")
    assert table.num_rows == 400
    assert set(table["recording"].to_pylist()) == {"a", "b"}
    words = ("recording", "status", "no_metres", "again")
    assert [table.schema.field(name).type for name in words] == [pa.string()] * 4
    assert table.schema.field("smoothed_aside").metadata == {b"unit": b"m"}
    aside, smoothed = (np.array(table[name].to_pylist(), float) for name in ("x", "smoothed_aside"))
    assert np.isfinite(aside).all() and np.isfinite(smoothed).mean() > 0.9


def test_a_time_that_comes_again_has_no_place_in_the_table_the_second_time(tmp_path):
    dive = make_dive(Plan(length=20.0))
    again = slice(200, 299)
    dive.table.rows["stamp"][200:] -= 10_000_000_000
    _, course = analyse(dive, SurveySettings())
    write_frames(tmp_path / "frames.parquet", "dive", dive, course)
    table = pq.read_table(tmp_path / "frames.parquet")
    for name in ("x", "y", "yaw", "smoothed_aside", "along"):
        column = np.array(table[name].to_pylist(), float)
        assert np.isnan(column[again]).all() and np.isfinite(column[10:200]).all()
        assert np.isfinite(column[310:]).all()


def test_rows_that_were_looked_at_again_say_so(tmp_path):
    dive = make_dive(Plan(length=4.0))
    dive.table.rows["again"][[2, 5]] = HIDDEN, SEEN
    write_frames(tmp_path / "frames.parquet", "dive", dive, None)
    column = pq.read_table(tmp_path / "frames.parquet")["again"].to_pylist()
    assert (column[0], column[2], column[5]) == ("", "hidden", "seen")
