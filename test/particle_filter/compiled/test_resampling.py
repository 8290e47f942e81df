import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.particle_filter.compiled.resampling import invert_cumulative_weights
from cable_tracker.particle_filter.resampling import POSITIONS, RESAMPLING_SCHEMES


@pytest.mark.parametrize("scheme", POSITIONS)
@given(
    raw=arrays(np.float64, st.integers(1, 40), elements=st.just(0.0) | st.floats(1e-300, 1.0)),
    count=st.integers(1, 60),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_same_particles_as_numpy(scheme, raw, count, seed):
    assume(raw.sum() > 0.0)
    weights = raw / raw.sum()
    positions = POSITIONS[scheme](count, np.random.default_rng(seed))
    found = np.empty(count, np.int64)
    invert_cumulative_weights(weights, positions, np.empty(len(weights)), found)
    expected = RESAMPLING_SCHEMES[scheme](weights, count, np.random.default_rng(seed))
    assert found.tolist() == expected.tolist()


@pytest.mark.parametrize("scheme", POSITIONS)
@given(count=st.integers(1, 60), seed=st.integers(0, 2**32 - 1))
def test_positions_ascend_from_0_to_1(scheme, count, seed):
    positions = POSITIONS[scheme](count, np.random.default_rng(seed))
    assert positions.shape == (count,)
    assert (np.diff(positions) >= 0.0).all()
    assert positions[0] >= 0.0
    assert positions[-1] < 1.0
