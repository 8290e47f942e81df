from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.sequences.natural_order import naturally_sorted, positions_by_number


def in_order(*names: str) -> list[str]:
    return [path.name for path in naturally_sorted(map(Path, names))]


def test_runs_of_digits_count_as_numbers():
    assert in_order("f10.png", "f9.png", "f1.png") == ["f1.png", "f9.png", "f10.png"]
    assert in_order("bag_1_10.mcap", "bag_1_2.mcap") == ["bag_1_2.mcap", "bag_1_10.mcap"]


@pytest.mark.parametrize(
    "names",
    [
        # Decimals, padded or not.
        ["frame_9.25.png", "frame_9.5.png", "frame_10.25.png", "frame_10.3.png"],
        ["1699999998.75.png", "1699999999.0.png", "1699999999.25.png", "1699999999.5.png"],
        ["lat54.05_0.5.png", "lat54.1_0.25.png", "lat54.1_0.5.png"],
        ["1.050.png", "1.500.png", "2.000.png"],
        # Numbers that count, with points between them.
        [f"dive1.{count}.png" for count in range(1, 21)],
        ["v1.2.9_0003.png", "v1.2.10_0001.png", "v1.2.10_0003.png", "v1.10.1_0001.png"],
        ["2023.9.28.png", "2023.11.5.png"],
        ["shot.9.png", "shot.10.png", "shot.11.png"],
        ["dive1.87.png", "dive1.96.png", "dive1.143.png"],
        ["1699999999.5000000.png", "1699999999.45000000.png", "1699999999.250000000.png"],
    ],
)
def test_digits_after_a_point_are_a_decimal_unless_they_count(names):
    assert in_order(*names) == in_order(*reversed(names)) == names


@given(st.sets(st.floats(1.0, 1e6)))
def test_numbers_come_in_their_order_however_many_decimals_they_have(numbers):
    plain = [0.5, *numbers]
    assert in_order(*(f"f{n!r}.png" for n in plain)) == [f"f{n!r}.png" for n in sorted(plain)]


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
        (["7.8.png", "7.9.png", "8.05.png", "8.1.png"], [0, 1, 2, 3]),
        (["7.1.png", "7.2.png", "7.35.png"], [0, 1, 34]),
        (["7.8.png", "7.9.png", "7.10.png", "7.12.png"], [0, 1, 2, 4]),
        ([], []),
    ],
)
def test_missing_numbers_are_gaps_where_names_are_numbered(names, positions):
    assert positions_by_number(names) == positions
