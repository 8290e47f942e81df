import math

import pytest

from cable_tracker.evaluation.result_table import ResultTable, format_number, table_csv


def test_unknown_numbers_are_left_empty_for_machines():
    assert table_csv(ResultTable(("a", "b"), (("–", "1"),))) == "a,b\n,1\n"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.234, "px", "1.23"),
        (12.34, "%", "12.3"),
        (-0.5, "deg", "−0.50"),
        (123.456, "px", "123.5"),
        (math.nan, "px", "–"),
        (math.inf, "", "∞"),
    ],
)
def test_numbers_have_as_many_digits_as_make_sense(value, unit, text):
    assert format_number(value, unit) == text
