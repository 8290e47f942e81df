from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.tracking.robust import median_of_sizes, robust_scale

SIZES = st.floats(0.0, float(np.finfo(np.float32).max), width=32)


@given(st.lists(SIZES | st.sampled_from([0.0, 1.0, 2.0]), min_size=1, max_size=40))
def test_a_median_has_as_many_on_either_side_whether_or_not_values_repeat(
    sizes: list[float],
) -> None:
    assert median_of_sizes(np.array(sizes, np.float32)) == sorted(sizes)[len(sizes) // 2]


def test_the_robust_scale_of_a_gaussian_is_its_standard_deviation_whatever_lies_far_out() -> None:
    values = np.random.default_rng(2).normal(0.0, 3.0, 20_000)
    values[:200] = 1e6
    sizes = np.abs(values).astype(np.float32)
    assert robust_scale(sizes) == pytest.approx(3.0, rel=0.03)
