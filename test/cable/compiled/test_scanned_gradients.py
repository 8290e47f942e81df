from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.cable.measure import scanned_gradients as plain

pytest.importorskip("numba")

from cable_tracker.cable.compiled.scanned_gradients import scan_frame

GREY_LEVEL = 3e-4
"""Single precision sums in another order [grey levels]."""


def assert_alike(pixels, spacing=7, sigma=1.6, lag=12) -> None:
    kernels = plain.scan_kernels(sigma, 3.0, lag)
    expected = plain.scan_frame(pixels, spacing, kernels)
    found = scan_frame(pixels, spacing, kernels)
    level = GREY_LEVEL * max(1.0, float(np.abs(pixels).max()) / 255.0)
    assert found.scale == pytest.approx(expected.scale, abs=level)
    assert found.contrast_scale == pytest.approx(expected.contrast_scale, abs=level)
    for one, other in ((found.rows, expected.rows), (found.columns, expected.columns)):
        np.testing.assert_array_equal(one.places, other.places)
        assert one.gradients.dtype == one.smooth.dtype == np.float32
        np.testing.assert_allclose(
            one.gradients * found.scale, other.gradients * expected.scale, atol=level
        )
        np.testing.assert_allclose(
            one.smooth * found.contrast_scale, other.smooth * expected.contrast_scale, atol=level
        )


@settings(max_examples=60)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(16, 90),
    st.integers(16, 90),
    st.integers(1, 40),
    st.sampled_from([0.5, 1.6, 5.0]),
)
def test_any_picture_is_scanned_alike(seed, width, height, spacing, sigma):
    rng = np.random.default_rng(seed)
    pixels = rng.uniform(0, 255, (height, width)).astype(np.float32)
    assert_alike(pixels, spacing, sigma, int(rng.integers(1, 13)))


@pytest.mark.parametrize("size", [(16, 16), (320, 1), (1, 320), (320, 2), (17, 300)])
@pytest.mark.parametrize("value", [0.0, 128.0, 255.0])
def test_a_flat_picture_of_any_shape_is_scanned_alike(size, value):
    assert_alike(np.full(size[::-1], value, np.float32))


@pytest.mark.parametrize("size", [(16, 16), (320, 1), (1, 320), (320, 2), (17, 300)])
def test_small_pictures_are_scanned_alike(size, rng):
    assert_alike(rng.uniform(0, 255, size[::-1]).astype(np.float32))


def test_whole_grey_levels_are_scanned_alike(rng):
    assert_alike(rng.integers(0, 256, (60, 80)).astype(np.uint8))


def test_large_levels_are_scanned_alike(rng):
    assert_alike(rng.uniform(-1e9, 1e9, (60, 80)).astype(np.float32))


def test_pictures_that_cannot_be_written_to_are_not_written_to(rng):
    pixels = rng.uniform(0, 255, (60, 80)).astype(np.float32)
    before = pixels.copy()
    pixels.setflags(write=False)
    assert_alike(pixels)
    np.testing.assert_array_equal(pixels, before)
