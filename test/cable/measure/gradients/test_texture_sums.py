from __future__ import annotations

import numpy as np

from cable_tracker.cable.measure.gradients.scan_filters import scan_kernels
from cable_tracker.cable.measure.gradients.scan_lines import ACROSS, ALONG
from cable_tracker.cable.measure.gradients.scanned_gradients import scan_frame
from cable_tracker.cable.measure.gradients.texture_sums import TEXTURE_STEP, summed_texture


def test_summed_texture_is_the_running_sum_of_gradients_over_grey_levels(rng):
    bottom = rng.normal(100.0, 10.0, (240, 320)).astype(np.float32)
    lines = scan_frame(bottom, 8, scan_kernels(1.6, 3.0, 12)).rows
    dark, most = 0.5, 0.02
    modulus = np.hypot(lines.gradients[..., ALONG], lines.gradients[..., ACROSS])
    relative = np.minimum(modulus / (np.maximum(lines.smooth, 0.0) + dark), most)[::TEXTURE_STEP]
    sums = summed_texture(lines.gradients, lines.smooth, dark, most)
    assert (sums[:, 0] == 0.0).all()
    np.testing.assert_allclose(sums[:, 1:], np.cumsum(relative, axis=1), rtol=1e-4)
