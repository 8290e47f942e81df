from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.gradients import MAP_COLUMNS, NOISE_FLOOR, gradient_field, read_channels


def ramp(x_slope, y_slope, size=(40, 30)) -> np.ndarray:
    """Grey levels that rise by so much per pixel, y up."""
    rows, columns = np.mgrid[: size[1], : size[0]]
    return (100.0 + x_slope * columns - y_slope * rows).astype(np.float32)


def test_the_gradient_points_to_where_it_gets_brighter_with_y_up():
    field = gradient_field(ramp(2.0, 3.0), 1.0)
    middle = field.channels[10:20, 10:30] * field.scale
    np.testing.assert_allclose(middle[..., 0], 2.0, rtol=1e-4)
    np.testing.assert_allclose(middle[..., 1], 3.0, rtol=1e-4)
    np.testing.assert_allclose(middle[..., 2:], 0.0, atol=1e-3)


def test_the_gradient_of_the_modulus_points_to_the_ridge_of_an_edge():
    picture = np.where(np.arange(60) < 30, 50.0, 200.0).astype(np.float32)
    channels = gradient_field(np.tile(picture, (40, 1)), 2.0).channels[20]
    assert channels[27, 2] > 0.0 > channels[32, 2]
    assert channels[29, 2] == pytest.approx(-channels[30, 2], rel=1e-3)


def test_the_field_is_in_units_of_the_noise(rng):
    noise = rng.normal(100.0, 4.0, (200, 300)).astype(np.float32)
    quiet, loud = gradient_field(noise, 1.6), gradient_field(100.0 + 7.0 * (noise - 100.0), 1.6)
    np.testing.assert_allclose(loud.channels, quiet.channels, atol=0.01)
    assert loud.scale == pytest.approx(7.0 * quiet.scale, rel=1e-3)
    assert quiet.channels[..., :2].std() == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("value", [0.0, 255.0])
def test_a_flat_picture_has_no_gradient_and_the_smallest_scale(value):
    field = gradient_field(np.full((20, 20), value, np.float32), 1.6)
    assert field.scale == NOISE_FLOOR
    np.testing.assert_allclose(field.channels, 0.0, atol=1e-3)


@pytest.mark.parametrize("count", [0, 1, MAP_COLUMNS, MAP_COLUMNS + 1])
def test_any_number_of_places_is_read(count):
    values = read_channels(ramp(1.0, 0.0), np.full(count, 3.5), np.full(count, 2.0))
    assert values.shape == (count, 1)
    np.testing.assert_allclose(values, 103.5)


def test_beyond_the_edge_the_outermost_pixels_go_on():
    values = read_channels(ramp(1.0, 0.0), np.array([-50.0, 90.0]), np.array([-9.0, 99.0]))
    np.testing.assert_allclose(values[:, 0], [100.0, 139.0])
