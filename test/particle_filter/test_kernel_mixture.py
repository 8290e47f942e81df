from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.particle_filter import kernel_mixture
from cable_tracker.particle_filter.kernel_mixture import KernelMixture
from cable_tracker.particle_filter.student_t import StudentT

SCALES = np.array([0.5, 2.0, 0.1])


def mixture(rng, centres=7, tail=4.0) -> KernelMixture:
    return KernelMixture(rng.normal(0.0, 3.0, (centres, 3)), SCALES, tail)


def brute_force(mixture, points, weights) -> np.ndarray:
    kernels = [
        StudentT(centre, np.diag(mixture.scales), mixture.degrees_of_freedom).log_density(points)
        for centre in mixture.centres
    ]
    return np.log(np.exp(np.array(kernels)).T @ weights)


@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 4.0, 50.0, math.inf]))
def test_the_density_is_the_weighted_sum_of_the_kernels(seed, tail):
    rng = np.random.default_rng(seed)
    cloud = mixture(rng, tail=tail)
    points = cloud.centres[rng.integers(0, 7, 9)] + rng.standard_normal((9, 3)) * SCALES
    first, second = rng.dirichlet(np.ones(7), 2)
    densities = cloud.log_densities(points, (first, second))
    assert densities.shape == (2, 9)
    for density, weights in zip(densities, (first, second), strict=True):
        np.testing.assert_allclose(density, brute_force(cloud, points, weights), atol=1e-6)


def test_more_points_than_are_looked_at_in_one_go(rng, monkeypatch):
    cloud, points, weights = mixture(rng), rng.normal(0.0, 3.0, (10, 3)), np.full(7, 1 / 7)
    at_once = cloud.log_densities(points, (weights,))
    monkeypatch.setattr(kernel_mixture, "POINTS_AT_ONCE", 3)
    np.testing.assert_allclose(cloud.log_densities(points, (weights,)), at_once)


@pytest.mark.parametrize("tail", [4.0, math.inf])
def test_points_far_away_have_a_small_density_and_no_warning(rng, tail):
    cloud = mixture(rng, tail=tail)
    with np.errstate(all="raise", under="ignore"):
        density = cloud.log_densities(np.full((1, 3), 1e6), (np.full(7, 1 / 7),))
    assert np.isfinite(density).all()
    assert density.max() < -50.0


def test_centres_without_a_weight_count_nothing(rng):
    cloud = KernelMixture(np.array([[0.0], [1e6]]), np.ones(1), math.inf)
    densities = cloud.log_densities(np.array([[1e6]]), (np.array([1.0, 0.0]),))
    assert densities[0, 0] == -math.inf


def test_draws_agree_with_the_density(rng, draw_standard):
    cloud = KernelMixture(np.array([[-1.0, 0.0], [2.0, 1.0]]), np.array([0.5, 1.0]), 4.0)
    weights = np.array([0.3, 0.7])
    draws = cloud.placed_about(rng.choice(2, 40_000, p=weights), draw_standard(40_000, 2, 4.0))
    in_box = (np.abs(draws[:, 0] - 0.5) < 2.0) & (np.abs(draws[:, 1] - 0.5) < 1.0)
    ratios = in_box / np.exp(cloud.log_densities(draws, (weights,))[0])
    error = ratios.std() / np.sqrt(len(ratios))
    assert ratios.mean() == pytest.approx(8.0, abs=5 * error)
    assert error < 0.5


def test_each_point_is_drawn_about_its_own_centre(draw_standard):
    cloud = KernelMixture(np.array([[0.0], [100.0]]), np.full(1, 0.01), math.inf)
    draws = cloud.placed_about(np.array([1, 0, 1]), draw_standard(3, 1, math.inf))
    np.testing.assert_allclose(draws[:, 0], [100.0, 0.0, 100.0], atol=0.1)
