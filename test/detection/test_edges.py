from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.edges import (
    GRADIENT_FLOOR,
    gradient_of,
    gradient_ridge,
    magnitude,
)
from cable_tracker.detection.search_region import SearchRegion


def slope(angle: float, steepness: float, size=(60, 50)) -> np.ndarray:
    width, height = size
    x, y = np.arange(width)[None, :], -np.arange(height)[:, None]
    return (100.0 + steepness * (x * np.cos(angle) + y * np.sin(angle))).astype(np.float32)


@pytest.mark.parametrize("degrees", [0, 30, 90, 200, 300])
def test_the_gradient_of_a_slope_points_up_it_with_y_up(degrees):
    angle = np.deg2rad(degrees)
    gradient = gradient_of(slope(angle, 2.0))
    np.testing.assert_allclose(gradient.x[5:-5, 5:-5], 2.0 * np.cos(angle), atol=1e-4)
    np.testing.assert_allclose(gradient.y[5:-5, 5:-5], 2.0 * np.sin(angle), atol=1e-4)
    np.testing.assert_allclose(gradient.modulus[5:-5, 5:-5], 2.0, atol=1e-4)


def test_the_scale_is_the_sigma_of_gaussian_components(rng):
    noise = rng.normal(0.0, 5.0, (240, 320)).astype(np.float32)
    gradient = gradient_of(noise)
    assert gradient.scale == pytest.approx(float(gradient.x.std()), rel=0.05)


def test_the_scale_of_a_flat_picture_is_the_floor():
    assert gradient_of(np.full((40, 40), 9.0, np.float32)).scale == GRADIENT_FLOOR


def test_the_ridge_follows_the_border(draw_strip):
    image = draw_strip(CableState(0.0, 0.0, 41.0)).astype(np.float32)
    gradient = gradient_of(image)
    ridge = gradient_ridge(gradient) & (gradient.modulus > 10)
    # The borders lie at the columns 159.5 - 20.5 and 159.5 + 20.5.
    np.testing.assert_array_equal(np.nonzero(ridge[100])[0], [139, 180])


def test_points_within_a_region_are_those_it_covers(edge_line, join):
    near, far = edge_line(0.0, 10.0, -20.0, 20.0), edge_line(0.0, 90.0, -20.0, 20.0)
    region = SearchRegion(CableState(10.0, 0.0, 20.0), distance=5.0, angle=0.1, width=5.0)
    both = join(near, far)
    assert len(both.within(region)) == len(near)
    assert both.within(None) is both


def test_equal_vectors_are_equally_long_wherever_they_lie_in_memory():
    rng = np.random.default_rng(5)
    x, y = (rng.normal(size=(123, 157)).astype(np.float32) for _ in range(2))
    expected = magnitude(x, y)
    np.testing.assert_allclose(expected, np.hypot(x, y), rtol=1e-6)
    for size in rng.integers(1, 5000, 40):
        moved = np.zeros(size + x.size, np.float32)[size:].reshape(x.shape)
        moved[...] = x
        np.testing.assert_array_equal(magnitude(moved, y), expected)
