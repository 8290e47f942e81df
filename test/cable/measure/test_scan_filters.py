from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.scan_filters import mirrored, scan_kernels


@given(st.integers(1, 40), st.integers(-500, 500))
def test_indices_beyond_the_edge_are_mirrored_as_opencv_does(length, index):
    expected = cv2.borderInterpolate(index, length, cv2.BORDER_REFLECT_101)
    assert mirrored(index, length) == expected


@pytest.mark.parametrize("sigma", [0.5, 1.6, 4.0])
def test_filters_keep_levels_and_answer_a_ramp_with_its_slope(sigma):
    kernels = scan_kernels(sigma, 3.0, 12)
    taps = np.arange(len(kernels.gaussian)) - len(kernels.gaussian) // 2
    assert len(taps) % 2 == 1
    assert kernels.gaussian.sum() == pytest.approx(1.0, abs=1e-6)
    assert kernels.region.sum() == pytest.approx(1.0, abs=1e-6)
    assert kernels.derivative @ taps == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_array_equal(kernels.derivative, -kernels.derivative[::-1])
    np.testing.assert_array_equal(kernels.gaussian, kernels.gaussian[::-1])
