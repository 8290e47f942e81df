from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.scan_filters import scan_kernels
from cable_tracker.cable.measure.scanned_gradients import (
    ACROSS,
    ALONG,
    LEAST_VARIANCE,
    NOISE_FLOOR,
    ROUND,
    SLOPE,
    SMALLEST_CONTRAST,
    directional_gain,
    gradient_shape,
    line_indices,
    scan_frame,
)

KERNELS = scan_kernels(1.6, 3.0, 12)
SPACING = 7
NO_FILTER = np.empty(0, np.float32)

ANGLES = st.floats(-np.pi, np.pi)


def scan(picture, spacing=SPACING, kernels=KERNELS):
    return scan_frame(picture, spacing, kernels, reduction=1.0, scale=1.0)


def ramp(x_slope, y_slope, size=(90, 70)) -> np.ndarray:
    """Grey levels that rise by so much per pixel, y up."""
    rows, columns = np.mgrid[: size[1], : size[0]]
    return (100.0 + x_slope * columns - y_slope * rows).astype(np.float32)


def inner(lines, margin=12) -> np.ndarray:
    return lines.gradients[2:-2, margin:-margin]


def noise(rng, size=(160, 120)) -> np.ndarray:
    return rng.normal(100.0, 4.0, size[::-1]).astype(np.float32)


@given(st.integers(1, 500), st.integers(1, 600))
def test_scan_lines_are_centred_and_equally_spaced_and_miss_no_part(length, spacing):
    lines = line_indices(length, spacing)
    assert len(lines) == (length - 1) // spacing + 1
    assert (np.diff(lines) == spacing).all()
    before, after = lines[0], length - 1 - lines[-1]
    assert 0 <= after - before <= 1
    assert before >= 0
    assert before + after < spacing


@given(st.floats(-4, 4), st.floats(-4, 4))
def test_a_ramp_has_its_slopes_everywhere_with_y_up(x_slope, y_slope):
    scanned = scan(ramp(x_slope, y_slope))
    rows, columns = (
        inner(lines) * scanned.gradient_scale for lines in (scanned.rows, scanned.columns)
    )
    for lines, along, across in ((rows, x_slope, y_slope), (columns, y_slope, x_slope)):
        np.testing.assert_allclose(lines[..., ALONG], along, atol=2e-3)
        np.testing.assert_allclose(lines[..., ACROSS], across, atol=2e-3)
        np.testing.assert_allclose(lines[..., SLOPE], 0.0, atol=2e-3)


def test_lines_know_where_they_are(rng):
    picture = noise(rng, (61, 43))
    scanned = scan(picture)
    rows, columns = line_indices(43, SPACING), line_indices(61, SPACING)
    assert scanned.rows.smooth.shape == (len(rows), 61)
    assert scanned.rows.gradients.shape == (len(rows), 61, 3)
    assert scanned.columns.smooth.shape == (len(columns), 43)
    np.testing.assert_array_equal(scanned.rows.places, 21.0 - rows)
    np.testing.assert_array_equal(scanned.columns.places, columns - 30.0)


def test_rows_and_columns_have_the_same_gradients_where_they_cross(rng):
    scanned = scan(noise(rng, (61, 43)))
    rows, columns = line_indices(43, SPACING), line_indices(61, SPACING)
    # Columns run upwards.
    of_rows = scanned.rows.gradients[:, columns]
    of_columns = scanned.columns.gradients[:, 42 - rows].transpose(1, 0, 2)
    np.testing.assert_allclose(of_rows[..., ALONG], of_columns[..., ACROSS], atol=1e-4)
    np.testing.assert_allclose(of_rows[..., ACROSS], of_columns[..., ALONG], atol=1e-4)
    smooth = scanned.columns.smooth[:, 42 - rows].T
    np.testing.assert_allclose(scanned.rows.smooth[:, columns], smooth, atol=1e-3)


def test_the_slope_points_to_the_ridge_of_an_edge_and_vanishes_there():
    picture = np.where(np.arange(61) < 30, 50.0, 200.0).astype(np.float32)
    picture[30] = 125.0
    lines = scan(np.tile(picture, (40, 1))).rows
    values = lines.gradients[len(lines.places) // 2]
    assert np.argmax(values[:, ALONG]) == 30
    assert values[28, SLOPE] > 0.0 > values[32, SLOPE]
    assert values[30, SLOPE] == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_allclose(values[31:37, SLOPE], -values[29:23:-1, SLOPE], atol=1e-3)
    np.testing.assert_allclose(values[..., ACROSS], 0.0, atol=1e-3)


def test_at_the_edge_of_the_picture_it_goes_on_as_its_mirror_image(rng):
    picture = noise(rng, (43, 29))
    margin = 14
    padded = np.pad(picture, margin, mode="reflect")
    scanned, wide = scan(picture, 1), scan(padded, 1)
    for one, other in ((scanned.rows, wide.rows), (scanned.columns, wide.columns)):
        inside = other.gradients[margin:-margin, margin:-margin] * (
            wide.gradient_scale / scanned.gradient_scale
        )
        np.testing.assert_allclose(one.gradients[..., :2], inside[..., :2], atol=1e-4)
        np.testing.assert_allclose(one.gradients[..., SLOPE], inside[..., SLOPE], atol=1e-4)
        scale = one.smooth / other.smooth[margin:-margin, margin:-margin]
        np.testing.assert_allclose(scale, scale.mean(), rtol=1e-5)


SIZES = [(61, 43), (64, 48), (16, 16), (50, 17)]


@pytest.mark.parametrize("size", SIZES)
def test_the_rows_of_a_picture_turned_by_a_quarter_are_the_columns_of_it(rng, size):
    picture = noise(rng, size)
    # Turned clockwise, what was up lies to the right, and what was right lies below.
    straight, turned = scan(picture), scan(np.ascontiguousarray(np.rot90(picture, -1)))
    columns = straight.columns.gradients * straight.gradient_scale
    rows = turned.rows.gradients * turned.gradient_scale
    np.testing.assert_allclose(rows[..., ALONG], columns[..., ALONG], atol=1e-4)
    np.testing.assert_allclose(rows[..., ACROSS], -columns[..., ACROSS], atol=1e-4)
    np.testing.assert_allclose(rows[..., SLOPE], columns[..., SLOPE], atol=1e-4)
    np.testing.assert_allclose(turned.rows.places, -straight.columns.places)


def test_a_transposed_picture_swaps_rows_and_columns(rng):
    picture = noise(rng, (61, 43))
    # About the diagonal that rises to the right, x and y change places.
    straight, swapped = scan(picture), scan(np.ascontiguousarray(picture[::-1, ::-1].T))
    for one, other in (
        (straight.rows, swapped.columns),
        (straight.columns, swapped.rows),
    ):
        factor = swapped.gradient_scale / straight.gradient_scale
        np.testing.assert_allclose(one.gradients, other.gradients[::-1] * factor, atol=1e-3)
        np.testing.assert_allclose(one.places, other.places[::-1])


@pytest.mark.parametrize("axis", [0, 1])
def test_a_mirrored_picture_has_mirrored_gradients(rng, axis):
    # Lines lie symmetrically in these sizes.
    picture = noise(rng, (57, 43))
    straight, flipped = scan(picture), scan(np.ascontiguousarray(np.flip(picture, axis)))
    signs = np.ones(3)
    signs[1 - axis] = -1.0
    signs[SLOPE] = -1.0 if axis else 1.0
    rows = np.flip(flipped.rows.gradients, axis) * signs * flipped.gradient_scale
    np.testing.assert_allclose(rows, straight.rows.gradients * straight.gradient_scale, atol=1e-4)


def test_scales_are_those_of_the_noise(rng):
    quiet_picture = noise(rng, (300, 200))
    loud_picture = (100.0 + 7.0 * (quiet_picture - 100.0)).astype(np.float32)
    quiet, loud = scan(quiet_picture), scan(loud_picture)
    assert loud.gradient_scale == pytest.approx(7.0 * quiet.gradient_scale, rel=1e-3)
    for one, other in ((quiet.rows, loud.rows), (quiet.columns, loud.columns)):
        np.testing.assert_allclose(other.gradients, one.gradients, atol=0.01)
        levels = other.smooth - one.smooth
        np.testing.assert_allclose(levels, levels.mean(), atol=0.01)
        assert one.gradients[..., :2].std() == pytest.approx(1.0, abs=0.1)
        lag = KERNELS.contrast_lag
        assert (one.smooth[:, lag:] - one.smooth[:, :-lag]).std() == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("size", [(20, 20), (16, 300), (1, 40), (40, 1)])
@pytest.mark.parametrize("value", [0.0, 255.0])
@pytest.mark.filterwarnings("error")
def test_a_flat_picture_of_any_size_has_no_gradient_and_the_smallest_scales(value, size):
    scanned = scan(np.full(size[::-1], value, np.float32))
    assert scanned.gradient_scale == NOISE_FLOOR
    for lines in (scanned.rows, scanned.columns):
        np.testing.assert_allclose(lines.gradients, 0.0, atol=2e-3)
        np.testing.assert_allclose(lines.smooth * SMALLEST_CONTRAST, value, atol=1e-3)


def test_gradients_alone_are_the_same_gradients_and_nothing_else_is_known(rng):
    picture = noise(rng)
    everything, alone = scan(picture), scan(picture, kernels=KERNELS._replace(region=NO_FILTER))
    assert alone.gradient_scale == everything.gradient_scale
    for known, bare in ((everything.rows, alone.rows), (everything.columns, alone.columns)):
        assert (bare.gradients[..., :SLOPE] == known.gradients[..., :SLOPE]).all()
        assert (bare.places == known.places).all()
        for other in (bare.gradients[..., SLOPE], bare.smooth):
            assert not other.any()


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
