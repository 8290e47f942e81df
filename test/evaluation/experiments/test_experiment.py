import csv

import cv2
import numpy as np

from cable_tracker.evaluation.experiments.experiment import (
    TABLE_MARKDOWN,
    ExperimentResult,
    FigureFile,
    result_markdown,
    write_experiment,
)
from cable_tracker.evaluation.result_table import TABLE_CSV, ResultTable


def test_tables_and_figures_are_written(tmp_path):
    picture = cv2.imencode(".png", np.zeros((4, 4), np.uint8))[1].tobytes()
    table = ResultTable(("a", "b [px]"), (("x", "−1.5"),))
    result = ExperimentResult("T", (table,), (FigureFile("f.png", picture),))
    write_experiment(tmp_path, result, "On a machine.")
    with (tmp_path / TABLE_CSV).open() as file:
        assert list(csv.reader(file)) == [["a", "b [px]"], ["x", "-1.5"]]
    text = (tmp_path / TABLE_MARKDOWN).read_text(encoding="utf-8")
    assert "| x | −1.5 |" in text
    assert "![f.png](f.png)" in text
    assert (tmp_path / "f.png").read_bytes() == picture
    assert {path.name for path in tmp_path.iterdir()} == set(result.file_names())


def test_several_tables_have_titles_and_files_of_their_own(tmp_path):
    tables = tuple(ResultTable(("a",), ((name,),), name, f"{name}.csv") for name in ("one", "two"))
    result = ExperimentResult("T", tables)
    write_experiment(tmp_path, result, "On a machine.")
    assert (tmp_path / "two.csv").read_text() == "a\ntwo\n"
    headings = [line for line in result_markdown(result, "").splitlines() if line.startswith("#")]
    assert headings == ["# T", "## one", "## two"]


def test_notes_stand_below_their_table():
    table = ResultTable(("a",), (("x",),), notes=("first", "second"))
    text = result_markdown(ExperimentResult("T", (table,)), "On a machine.")
    assert text == "# T\n\nOn a machine.\n\n| a |\n|---|\n| x |\n\n- first\n- second\n"
