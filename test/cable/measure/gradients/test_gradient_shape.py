from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.gradients.gradient_shape import (
    LEAST_VARIANCE,
    ROUND,
    directional_gain,
    gradient_shape,
)

ANGLES = st.floats(-np.pi, np.pi)


def families(rng, covariance, count=60):
    """Gradients of rows and of columns that are drawn from one covariance, float32."""
    factor = np.linalg.cholesky(np.asarray(covariance))
    x, y = np.moveaxis(rng.standard_normal((2, count, 4 * count, 2)) @ factor.T, -1, 0)
    rows = np.stack((x[0], y[0], np.zeros_like(x[0])), axis=-1)
    columns = np.stack((y[1], x[1], np.zeros_like(x[1])), axis=-1)
    return rows.astype(np.float32), columns.astype(np.float32)


@pytest.mark.parametrize(
    "covariance", [[[1.0, 0.0], [0.0, 1.0]], [[9.0, 2.0], [2.0, 1.0]], [[0.5, -0.4], [-0.4, 2.0]]]
)
def test_the_shape_is_that_of_the_covariance_whatever_its_size(rng, covariance):
    found = gradient_shape(*families(rng, covariance))
    wanted = 2.0 * np.array(covariance) / np.trace(covariance)
    assert found.xx == pytest.approx(wanted[0, 0], abs=0.1)
    assert found.xy == pytest.approx(wanted[0, 1], abs=0.1)
    assert found.yy == pytest.approx(wanted[1, 1], abs=0.1)


def test_a_few_strong_edges_weigh_no_more_than_grain(rng):
    rows, columns = families(rng, np.eye(2))
    rows[:3, :, 0] = 100.0
    found = gradient_shape(rows, columns)
    assert found.xx == pytest.approx(1.0, abs=0.2)


def test_a_flat_picture_and_rounding_have_no_direction():
    flat = np.zeros((4, 16, 3), np.float32)
    assert gradient_shape(flat, flat) == ROUND
    flat[..., 0] = 0.01
    assert gradient_shape(flat, flat) == ROUND


@given(angle=ANGLES)
def test_stripes_have_a_bounded_gain_along_them(angle):
    rows = np.zeros((8, 32, 3), np.float32)
    rows[..., 0], rows[..., 1] = 3.0 * np.cos(angle), 3.0 * np.sin(angle)
    shape = gradient_shape(rows, np.zeros_like(rows))
    across = directional_gain(shape, np.cos(angle), np.sin(angle))
    along = directional_gain(shape, -np.sin(angle), np.cos(angle))
    assert across == pytest.approx(np.sqrt(0.5), rel=0.05)
    assert across < along <= 1.0 / np.sqrt(LEAST_VARIANCE) + 1e-9


@given(angle=ANGLES)
def test_a_round_shape_changes_nothing(angle):
    assert directional_gain(ROUND, np.cos(angle), np.sin(angle)) == pytest.approx(1.0)
