"""Equations are solved as NumPy solves them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cholesky import cholesky_factor, solve_factored


def positive_matrix(size: int, seed: int) -> np.ndarray:
    root = np.random.default_rng(seed).normal(size=(size, size))
    return root @ root.T + np.eye(size)


@given(size=st.integers(1, 6), seed=st.integers(0, 1000))
def test_a_factor_times_its_transpose_is_the_matrix(size: int, seed: int) -> None:
    matrix, factor = positive_matrix(size, seed), np.zeros((size, size))
    cholesky_factor(matrix, factor)
    assert factor == pytest.approx(np.linalg.cholesky(matrix))


@given(size=st.integers(1, 6), seed=st.integers(0, 1000))
def test_equations_are_solved(size: int, seed: int) -> None:
    matrix, factor = positive_matrix(size, seed), np.zeros((size, size))
    cholesky_factor(matrix, factor)
    values = np.arange(1.0, size + 1)
    solution = values.copy()
    solve_factored(factor, solution)
    assert matrix @ solution == pytest.approx(values, abs=1e-8)


def test_the_leading_block_of_a_larger_matrix_is_factored_alone() -> None:
    matrix, factor = positive_matrix(6, 3), np.zeros((4, 4))
    cholesky_factor(matrix, factor)
    assert factor == pytest.approx(np.linalg.cholesky(matrix[:4, :4]))
