import csv
import io
import math
from dataclasses import dataclass

from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.sequences.tables.csv_tables import csv_text, write_csv, write_records

CELLS = st.text(st.characters(exclude_characters="\r\0", exclude_categories=("Cs",)))


@given(st.lists(st.lists(CELLS, min_size=2, max_size=4)))
def test_any_cells_are_read_back(rows):
    text = csv_text(["a", "b"], rows)
    assert list(csv.reader(io.StringIO(text, newline=""))) == [["a", "b"], *rows]


def test_lines_end_with_a_line_feed_and_cells_with_commas_are_quoted():
    assert csv_text(("a", "b"), [(1, "x,y"), ("", 2.5)]) == 'a,b\n1,"x,y"\n,2.5\n'


def test_a_file_holds_the_text_of_the_table(tmp_path):
    path, rows = tmp_path / "table.csv", [(1, "x,y"), ("", "\u00e9")]
    write_csv(path, ("a", "b"), iter(rows))
    assert path.read_bytes() == csv_text(("a", "b"), rows).encode()


def test_letters_of_names_that_are_not_utf_8_are_replaced(tmp_path):
    write_csv(tmp_path / "table.csv", ("name",), [("Tauchg\udce4nge",)])
    assert (tmp_path / "table.csv").read_text(encoding="utf-8") == "name\nTauchg?nge\n"


@dataclass
class Record:
    name: str
    count: int
    depth: float
    is_told: bool


def test_records_have_a_column_for_each_field_and_what_is_not_known_is_empty(tmp_path):
    records = [Record("nan", 3, 1.5, True), Record("", 0, math.nan, False)]
    write_records(tmp_path / "table.csv", Record, iter(records))
    lines = (tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()
    assert lines == ["name,count,depth,is_told", "nan,3,1.50000,true", ",0,,false"]
