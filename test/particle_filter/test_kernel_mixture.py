from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.particle_filter.kernel_mixture import (
    choose_kernel,
    evaluate_kernels,
    kernel_mixture,
    weighted_sums,
)
from cable_tracker.particle_filter.student_t import peak_density, relative_density

SCALES = np.array([0.5, 2.0, 0.1, 1.0])


def literal_kernels(mixture, point) -> np.ndarray:
    """Densities of all kernels at a point, written down from their definition."""
    return np.array(
        [
            peak_density(mixture.degrees_of_freedom, 4)
            / np.prod(mixture.scales)
            * relative_density(
                float((((point - place) / mixture.scales) ** 2).sum()),
                mixture.degrees_of_freedom,
                4,
            )
            for place in mixture.places
        ]
    )


def looked_at(mixture, point) -> np.ndarray:
    evaluate_kernels(mixture, point)
    return mixture.values


@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 4.0, 50.0, math.inf]))
def test_the_density_is_the_weighted_sum_of_the_kernels(seed, tail):
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(7))
    mixture = kernel_mixture(rng.normal(0.0, 3.0, (7, 4)), SCALES, tail, weights)
    for _ in range(5):
        point = mixture.places[rng.integers(7)] + rng.standard_normal(4) * SCALES
        expected = literal_kernels(mixture, point)
        kernels = looked_at(mixture, point)
        np.testing.assert_allclose(kernels * mixture.peak, expected, rtol=1e-3, atol=1e-9)
        sums = np.array(weighted_sums(mixture)) * mixture.peak
        np.testing.assert_allclose(sums, [expected @ weights, expected.mean()], rtol=1e-3)


@pytest.mark.parametrize("tail", [4.0, math.inf])
def test_points_far_away_have_hardly_any_density(rng, tail):
    mixture = kernel_mixture(rng.normal(0.0, 3.0, (7, 4)), SCALES, tail, np.full(7, 1 / 7))
    kernels = looked_at(mixture, np.full(4, 1e4))
    assert ((kernels >= 0.0) & (kernels < 1e-15)).all()


def test_a_kernel_is_chosen_by_its_share_of_the_sum(rng):
    weights = np.array([0.2, 0.5, 0.3])
    mixture = kernel_mixture(np.zeros((3, 4)), SCALES, 4.0, weights)
    evaluate_kernels(mixture, np.zeros(4))
    total = 0.7 * mixture.peak
    chosen = [choose_kernel(mixture, 0.7, share * total) for share in (0.1, 0.3, 0.69, 0.71)]
    assert chosen == [0, 1, 1, 2]
    assert choose_kernel(mixture, 0.7, 1.1 * total) == -1


@given(count=st.integers(1, 100), seed=st.integers(0, 100), share=st.floats(0.001, 0.999))
def test_a_kernel_is_chosen_where_the_sum_of_those_before_it_passes_the_position(
    count: int, seed: int, share: float
) -> None:
    rng = np.random.default_rng(seed)
    mixture = kernel_mixture(rng.normal(size=(count, 4)), SCALES, 4.0, np.full(count, 1.0 / count))
    evaluate_kernels(mixture, np.zeros(4))
    sums = np.cumsum(0.7 * mixture.peak * mixture.weights.astype(float) * mixture.values)
    chosen = choose_kernel(mixture, 0.7, share * sums[-1])
    before = sums[chosen - 1] if chosen else 0.0
    assert before <= share * sums[-1] * (1.0 + 1e-5)
    assert share * sums[-1] <= sums[chosen] * (1.0 + 1e-5)
