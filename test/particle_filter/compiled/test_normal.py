import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.particle_filter.compiled.normal import fill_normals
from cable_tracker.particle_filter.normal import normals_from_uniforms

UNIFORMS = arrays(np.float64, st.integers(1, 70), elements=st.floats(0.0, 1.0, exclude_max=True))


@given(UNIFORMS)
@example(np.array([0.0, 0.125, 0.5, np.nextafter(1.0, 0.0)]))
def test_the_same_normal_numbers_as_numpy(uniforms):
    count = len(uniforms)
    found = np.empty(2 * count, np.float32)
    fill_normals(uniforms, found[:count], found[count:])
    np.testing.assert_allclose(found, normals_from_uniforms(uniforms), atol=1e-5)
