from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.sequences.encodings import decode_bgr, raw_from_array
from cable_tracker.sequences.pictures.shown_levels import decode_shown, shown_levels

LEVELS = np.linspace(40.0, 200.0, 120 * 160, dtype=np.float32).reshape(120, 160)


def deep(bits):
    """Return a picture of so many bits as a camera stores it in 16."""
    return raw_from_array((LEVELS / 255.0 * (2**bits - 1)).astype(np.uint16), "mono16")


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_a_deep_camera_that_uses_few_levels_is_shown_so_that_one_sees_it(bits):
    assert decode_bgr(deep(bits)).max() < 60
    shown = decode_shown(deep(bits))
    assert (shown.dtype, shown.shape) == (np.uint8, (120, 160, 3))
    assert np.ptp(shown) > 30
    assert shown.mean() > 20


def test_a_deep_camera_that_uses_its_levels_is_shown_as_it_is():
    assert np.array_equal(decode_shown(deep(16)), decode_bgr(deep(16)))


def test_bytes_are_shown_as_they_are_however_dim():
    dim = (LEVELS / 50.0).astype(np.uint8)
    assert shown_levels(dim) is dim
    assert np.array_equal(decode_shown(raw_from_array(dim, "mono8"))[:, :, 0], dim)


def test_amplification_saturates_few_pixels():
    pale = (100.0 + LEVELS / 20.0).astype(np.float32)
    shown = shown_levels(pale)
    assert np.ptp(shown) > 2 * np.ptp(pale)
    assert (shown == 255).mean() < 0.1


@pytest.mark.parametrize("level", [0.0, 0.3, 40.0])
def test_a_picture_of_one_level_stays_as_it_is(level):
    assert (shown_levels(np.full((24, 32), level, np.float32)) == round(level)).all()


@pytest.mark.parametrize("light", [1.0, 3.0, 8.0, 20.0])
def test_a_dive_that_grows_a_little_brighter_does_not_flicker(light):
    dim = light / 160.0 * LEVELS
    before, after = (shown_levels((g * dim).astype(np.float32)) for g in (1.0, 1.02))
    assert abs(before.mean() - after.mean()) < 3.0
