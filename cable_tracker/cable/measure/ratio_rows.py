"""The sums of log-likelihood ratios of the points of a border, for all classes at a time.

A point has a row in each of two tables, with one column for each class: eight numbers that are
added to eight sums. LLVM works out neighbouring elements of a loop at a time, but not the columns
of a row, so here it is told to: `_sum_rows` is `add_ratio_rows` in its instructions. The columns do
not mix, so that every sum is the same bit for bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, overload
from numba.np.arrayobj import make_array

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.response_bins import CLASSES
from cable_tracker.cable.measure.response_table import LARGEST_RATIO
from cable_tracker.compilation import INSIDE

COLUMNS = 2 * CLASSES
"""Classes of bright cables, then of dark ones."""

ROW = ir.VectorType(ir.FloatType(), COLUMNS)
FLOAT_BYTES = 4
"""Rows begin at any float."""


def add_ratio_rows(edges: Image, contrasts: Image, cells: Image, count: int, sums: Image) -> None:
    """Add the ratios of points to the sums of their border, one point after the other.

    Parameters
    ----------
    edges, contrasts : Image
        The tables, float32, shapes (E, 8) and (C, 8).
    cells : Image
        Row of each point in either table, uint32, shape (2 or more, P).
    count : int
        Number of points.
    sums : Image
        Sums of each column, float32, shape (8,); the two rows of a point count for no more than
        `LARGEST_RATIO` together.
    """
    for index in range(count):
        sums += np.minimum(edges[cells[0, index]] + contrasts[cells[1, index]], LARGEST_RATIO)


@overload(add_ratio_rows, jit_options=INSIDE, strict=False)  # type: ignore[untyped-decorator]
def _compiled_add_ratio_rows(*_: Any) -> Any:  # noqa: ANN401
    def add(edges: Image, contrasts: Image, cells: Image, count: int, sums: Image) -> None:
        _sum_rows(edges, contrasts, cells, count, sums)

    return add


@intrinsic  # type: ignore[untyped-decorator]
def _sum_rows(
    _: object, edges: object, contrasts: object, cells: object, count: object, sums: object
) -> Any:  # noqa: ANN401
    """Return the types and the instructions of `add_ratio_rows`; all arrays are contiguous."""
    return types.void(edges, contrasts, cells, count, sums), _write_instructions


def _write_instructions(context: Any, builder: Any, signature: Any, values: Any) -> Any:  # noqa: ANN401
    edges, contrasts, cells, sums = (
        make_array(signature.args[place])(context, builder, values[place]) for place in (0, 1, 2, 4)
    )
    points = builder.extract_value(cells.shape, 1)
    largest = ir.Constant(ROW, [float(LARGEST_RATIO)] * COLUMNS)

    def row_of(table: Any, cell: Any) -> Any:  # noqa: ANN401
        rows = builder.bitcast(table.data, ROW.as_pointer())
        place = builder.zext(builder.load(builder.gep(cells.data, [cell])), points.type)
        return _load_row(builder, builder.gep(rows, [place]))

    result = builder.bitcast(sums.data, ROW.as_pointer())
    total = cgutils.alloca_once_value(builder, _load_row(builder, result))
    with cgutils.for_range(builder, values[3]) as loop:
        both = builder.fadd(
            row_of(edges, loop.index), row_of(contrasts, builder.add(points, loop.index))
        )
        ratio = builder.select(builder.fcmp_ordered("<", largest, both), largest, both)
        builder.store(builder.fadd(builder.load(total), ratio), total)
    builder.store(builder.load(total), result).align = FLOAT_BYTES
    return context.get_dummy_value()


def _load_row(builder: Any, place: Any) -> Any:  # noqa: ANN401
    row = builder.load(place)
    row.align = FLOAT_BYTES
    return row
