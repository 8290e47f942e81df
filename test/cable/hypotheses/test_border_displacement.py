from __future__ import annotations

import numpy as np

from cable_tracker.cable.hypotheses.border_displacement import displacement_factor


def test_fainter_borders_are_displaced_farther_within_limits():
    factors = [displacement_factor(evidence) for evidence in (3.0, 1.7, 1.3, 0.9, 0.0, -5.0)]
    np.testing.assert_allclose(factors, [1.0, 1.0, 2.0, 3.0, 4.0, 4.0])
