import numpy as np
import pytest

from cable_tracker.particle_filter.normal import normals_from_uniforms, standard_normals


def test_the_numbers_are_standard_normal_and_independent(rng):
    normals = standard_normals(rng, 4, 100_000)
    np.testing.assert_allclose(normals.mean(axis=1), 0.0, atol=0.02)
    np.testing.assert_allclose(np.cov(normals), np.eye(4), atol=0.02)
    # Of a Gaussian: 68.27 %, 95.45 % and 99.73 % within one, two and three sigma.
    within = [(np.abs(normals) < sigma).mean() for sigma in (1, 2, 3)]
    np.testing.assert_allclose(within, [0.6827, 0.9545, 0.9973], atol=0.003)


@pytest.mark.parametrize("uniform", [0.0, 0.25, 0.5, np.nextafter(1.0, 0.0)])
def test_every_uniform_number_makes_finite_ones(uniform):
    normals = normals_from_uniforms(np.array([uniform]))
    assert np.isfinite(normals).all()
    assert np.abs(normals).max() < 6.1


@pytest.mark.parametrize("rows", [0, 1, 2, 5, 6])
def test_as_many_rows_as_asked_for(rng, rows):
    assert standard_normals(rng, rows, 7).shape == (rows, 7)
