"""Cholesky factors of small matrices, for kernels: LAPACK is called for large ones."""

from __future__ import annotations

import math

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled_loop


@compiled_loop
def cholesky_factor(matrix: FloatArray, factor: FloatArray) -> None:
    """Fill in the lower factor (n, n) of a matrix's leading block; only its lower half is read."""
    for row in range(len(factor)):
        for column in range(row + 1):
            total = matrix[row, column]
            for index in range(column):
                total -= factor[row, index] * factor[column, index]
            if row == column:
                factor[row, row] = math.sqrt(total)
            else:
                factor[row, column] = total / factor[column, column]


@compiled_loop
def solve_factored(factor: FloatArray, values: FloatArray) -> None:
    """Replace the right side (n,) of linear equations by their solution.

    `factor` is the lower factor of their matrix, see `cholesky_factor`.
    """
    size = len(values)
    for row in range(size):
        for index in range(row):
            values[row] -= factor[row, index] * values[index]
        values[row] /= factor[row, row]
    for row in range(size - 1, -1, -1):
        for index in range(row + 1, size):
            values[row] -= factor[index, row] * values[index]
        values[row] /= factor[row, row]
