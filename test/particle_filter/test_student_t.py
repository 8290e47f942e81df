from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.particle_filter.student_t import (
    choose_kernel,
    evaluate_kernels,
    kernel_mixture,
    peak_density,
    relative_density,
    relative_log_density,
    standard_student_t,
    weighted_sums,
)

TAILS = [1.0, 2.5, 4.0, 30.0, math.inf]
COUNT = 40_000

SCALES = np.array([0.5, 2.0, 0.1, 1.0])


def density(x, tail, dimensions=1) -> np.ndarray:
    peak = peak_density(tail, dimensions)
    return np.array([peak * relative_density(value**2, tail, dimensions) for value in x])


@pytest.mark.parametrize("tail", TAILS)
def test_the_density_integrates_to_one(tail):
    # On a line that is bent so that even a Cauchy tail fits: x = tan(u).
    u = np.linspace(-np.pi / 2, np.pi / 2, 4001)[1:-1]
    x = np.tan(u)
    integral = np.sum(density(x, tail) * (1 + x**2)) * (u[1] - u[0])
    assert integral == pytest.approx(1.0, abs=2e-3)


def test_a_gaussian_and_a_cauchy_density_worked_by_hand():
    x = np.array([0.0, 1.0, 3.0])
    np.testing.assert_allclose(density(x, math.inf), [0.398942, 0.241971, 0.00443185], rtol=1e-5)
    np.testing.assert_allclose(density(x, 1.0), 1 / (np.pi * (1 + x**2)))


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
def test_the_usual_tail_is_that_of_the_general_formula(dimensions):
    for squared in (0.0, 0.3, 7.0, 1e4):
        general = (1.0 + squared / 4.0) ** (-0.5 * (4.0 + dimensions))
        assert relative_density(squared, 4.0, dimensions) == pytest.approx(general, rel=1e-12)


def test_the_peak_of_the_usual_tail_worked_by_hand():
    assert peak_density(4.0, 1) == pytest.approx(3.0 / 8.0)
    # Gamma(4) / Gamma(2) / (4 pi)^2
    assert peak_density(4.0, 4) == pytest.approx(6.0 / (4.0 * math.pi) ** 2)


@pytest.mark.parametrize("tail", TAILS)
def test_draws_have_the_quantiles_of_the_density(tail, rng):
    draws = standard_student_t(rng, COUNT, 1, tail)[:, 0]
    x = np.linspace(-2.0, 2.0, 2001)
    within = np.sum(density(x, tail)) * (x[1] - x[0])
    assert (np.abs(draws) < 2.0).mean() == pytest.approx(within, abs=0.012)
    assert (draws < 0).mean() == pytest.approx(0.5, abs=0.012)


def test_zero_draws_give_empty_arrays(rng):
    assert standard_student_t(rng, 0, 3, 4.0).shape == (0, 3)


@pytest.mark.parametrize("tail", TAILS)
def test_the_logarithm_of_the_density_is_that(tail):
    for squared in np.linspace(-3.0, 3.0, 7) ** 2:
        density_there = relative_density(squared, tail, 2)
        assert relative_log_density(squared, tail, 2) == pytest.approx(math.log(density_there))


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
