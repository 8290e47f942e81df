from __future__ import annotations

from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.sequences.natural_order import natural_key


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
