from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.sequences.natural_order import natural_key, positions_by_number


def in_order(*names: str) -> list[str]:
    return [path.name for path in sorted(map(Path, names), key=natural_key)]


def test_runs_of_digits_count_as_numbers():
    assert in_order("f10.png", "f9.png", "f1.png") == ["f1.png", "f9.png", "f10.png"]
    assert in_order("bag_1_10.mcap", "bag_1_2.mcap") == ["bag_1_2.mcap", "bag_1_10.mcap"]


@given(st.lists(st.text(alphabet="a1٣²0_.-", min_size=1, max_size=8).filter(lambda s: s != ".")))
def test_the_order_does_not_depend_on_the_listing(names):
    assert in_order(*names) == in_order(*reversed(names))


@given(st.lists(st.integers(0, 10**12), unique=True))
def test_numbered_files_come_in_the_order_of_their_numbers(numbers):
    assert in_order(*(f"f{n}.png" for n in numbers)) == [f"f{n}.png" for n in sorted(numbers)]


@pytest.mark.parametrize(
    ("names", "positions"),
    [
        (["f_1.png", "f_2.png", "f_3.png"], [0, 1, 2]),
        (["f_1.png", "f_2.png", "f_5.png"], [0, 1, 4]),
        (["f_0010.png", "f_0020.png", "f_0040.png"], [0, 1, 3]),
        (["dive2_f9.png", "dive2_f10.png", "dive2_f12.png"], [0, 1, 3]),
        (["a.png", "b.png", "e.png"], [0, 1, 2]),
        (["1718000000040.png", "1718000000081.png", "1718000000120.png"], [0, 1, 2]),
        (["1_9.png", "2_1.png", "4_7.png"], [0, 1, 2]),
        (["f_1.png", "f_9.png"], [0, 1]),
        (["f_1.jpg", "f_1.png", "f_3.png"], [0, 1, 2]),
        (["f_1.png", "f_2.png", "f_99999.png"], [0, 1, 2]),
        ([], []),
    ],
)
def test_missing_numbers_are_gaps_where_names_are_numbered(names, positions):
    assert positions_by_number(names) == positions
