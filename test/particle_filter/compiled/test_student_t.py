from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.particle_filter.student_t import student_t_log_density

pytest.importorskip("numba")

from cable_tracker.particle_filter.compiled.student_t import peak_density, tail

DEGREES = st.one_of(st.just(math.inf), st.just(4.0), st.floats(1.0, 1000.0))


@given(st.floats(0.0, 1000.0), DEGREES, st.sampled_from([1, 4]))
def test_peak_times_tail_is_the_density(squared, degrees_of_freedom, dimensions):
    density = peak_density(degrees_of_freedom, dimensions) * tail(
        squared, degrees_of_freedom, dimensions
    )
    log_density = student_t_log_density(np.array([squared]), dimensions, degrees_of_freedom, 0.0)
    assert density == pytest.approx(math.exp(log_density[0]), rel=1e-9, abs=1e-300)


@given(DEGREES, st.sampled_from([1, 4]))
def test_the_tail_is_one_at_the_peak_and_nothing_at_infinity(degrees_of_freedom, dimensions):
    assert tail(0.0, degrees_of_freedom, dimensions) == 1.0
    assert tail(math.inf, degrees_of_freedom, dimensions) == 0.0
