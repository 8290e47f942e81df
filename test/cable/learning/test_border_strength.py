from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.learning.border_strength import border_strength, strength_class


def test_the_strength_of_a_border_is_the_mean_of_its_upper_half():
    assert border_strength(np.array([5.0, -9.0, 3.0, 0.0], np.float32)) == pytest.approx(4.0)
    assert border_strength(np.array([1.0, 7.0, 3.0], np.float32)) == pytest.approx(5.0)
    classes = [strength_class(strength) for strength in (0.0, 1.19, 1.2, 2.0, 3.9, 99.0)]
    assert classes == [-1, -1, 0, 1, 2, 3]
