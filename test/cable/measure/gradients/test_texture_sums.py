from __future__ import annotations

import numpy as np

from cable_tracker.cable.measure.gradients.scan_filters import scan_kernels
from cable_tracker.cable.measure.gradients.scan_lines import ACROSS, ALONG
from cable_tracker.cable.measure.gradients.scanned_gradients import scan_frame
from cable_tracker.cable.measure.gradients.texture_sums import (
    ACROSS_LINES,
    ALONG_LINES,
    MIXED,
    TEXTURE_STEP,
    summed_texture,
)

DARK, MOST = 0.5, 0.02


def test_summed_texture_is_the_running_sum_of_gradients_over_grey_levels(rng):
    lines, sums = summed(rng)
    modulus = np.hypot(lines.gradients[..., ALONG], lines.gradients[..., ACROSS])
    relative = np.minimum(modulus / (np.maximum(lines.smooth, 0.0) + DARK), MOST)[::TEXTURE_STEP]
    assert (sums[:, 0] == 0.0).all()
    sizes = sums[:, 1:, ALONG_LINES] + sums[:, 1:, ACROSS_LINES]
    np.testing.assert_allclose(sizes, np.cumsum(relative, axis=1), rtol=1e-4)


def test_gradients_keep_their_direction_in_the_sums(rng):
    lines, sums = summed(rng)
    each = np.diff(sums, axis=1)
    u, v = (lines.gradients[::TEXTURE_STEP, :, column] for column in (ALONG, ACROSS))
    share = u * v / (u * u + v * v)
    sizes = each[..., ALONG_LINES] + each[..., ACROSS_LINES]
    np.testing.assert_allclose(each[..., MIXED], share * sizes, atol=1e-4)


def test_a_flat_picture_has_no_texture():
    flat = np.full((24, 32), 100.0, np.float32)
    lines = scan_frame(flat, 8, scan_kernels(1.6, 3.0, 12)).rows
    assert (summed_texture(lines.gradients, lines.smooth, DARK, MOST) == 0.0).all()


def summed(rng):
    """The rows of a rough picture, and the sums along them."""
    bottom = rng.normal(100.0, 10.0, (240, 320)).astype(np.float32)
    lines = scan_frame(bottom, 8, scan_kernels(1.6, 3.0, 12)).rows
    return lines, summed_texture(lines.gradients, lines.smooth, DARK, MOST)
