import csv
import io

from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.sequences.csv_text import csv_text

CELLS = st.text(st.characters(exclude_characters="\r\0", exclude_categories=("Cs",)))


@given(st.lists(st.lists(CELLS, min_size=2, max_size=4)))
def test_any_cells_are_read_back(rows):
    text = csv_text(["a", "b"], rows)
    assert list(csv.reader(io.StringIO(text, newline=""))) == [["a", "b"], *rows]


def test_lines_end_with_a_line_feed_and_cells_with_commas_are_quoted():
    assert csv_text(("a", "b"), [(1, "x,y"), ("", 2.5)]) == 'a,b\n1,"x,y"\n,2.5\n'
