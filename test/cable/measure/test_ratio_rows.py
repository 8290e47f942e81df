"""The sums of ratios that the processor takes eight at a time are those taken one by one."""

from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.ratio_rows import COLUMNS, add_ratio_rows
from cable_tracker.cable.measure.response_table import LARGEST_RATIO
from cable_tracker.compilation import compiled

EDGE_ROWS, CONTRAST_ROWS, ROOM = 50, 30, 64


@compiled
def _compiled_sums(edges: Image, contrasts: Image, cells: Image, count: int, sums: Image) -> None:
    add_ratio_rows(edges, contrasts, cells, count, sums)


def _tables(rng: np.random.Generator) -> tuple[Image, Image, Image]:
    edges = rng.normal(0.0, 2.0, (EDGE_ROWS, COLUMNS)).astype(np.float32)
    contrasts = rng.normal(0.0, 2.0, (CONTRAST_ROWS, COLUMNS)).astype(np.float32)
    cells = np.empty((4, ROOM), np.uint32)
    cells[0] = rng.integers(0, EDGE_ROWS, ROOM)
    cells[1] = rng.integers(0, CONTRAST_ROWS, ROOM)
    return edges, contrasts, cells


@pytest.mark.parametrize("count", [0, 1, 7, 30, ROOM])
def test_sums_are_those_of_one_point_after_the_other(count: int) -> None:
    edges, contrasts, cells = _tables(np.random.default_rng(count))
    expected = np.arange(COLUMNS, dtype=np.float32)
    found = expected.copy()
    add_ratio_rows(edges, contrasts, cells, count, expected)
    _compiled_sums(edges, contrasts, cells, count, found)
    np.testing.assert_array_equal(found, expected)


def test_a_point_counts_for_no_more_than_the_largest_ratio() -> None:
    high = np.full((1, COLUMNS), LARGEST_RATIO, np.float32)
    cells, sums = np.zeros((2, 3), np.uint32), np.zeros(COLUMNS, np.float32)
    _compiled_sums(high, high, cells, 3, sums)
    expected = np.float32(LARGEST_RATIO + LARGEST_RATIO) + LARGEST_RATIO
    np.testing.assert_array_equal(sums, np.full(COLUMNS, expected, np.float32))
