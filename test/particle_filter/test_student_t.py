from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.particle_filter.student_t import (
    peak_density,
    relative_density,
    relative_log_density,
    standard_student_t,
)

TAILS = [1.0, 2.5, 4.0, 30.0, math.inf]
COUNT = 40_000


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


def test_no_draws_are_no_problem(rng):
    assert standard_student_t(rng, 0, 3, 4.0).shape == (0, 3)


@pytest.mark.parametrize("tail", TAILS)
def test_the_logarithm_of_the_density_is_that(tail):
    for squared in np.linspace(-3.0, 3.0, 7) ** 2:
        density_there = relative_density(squared, tail, 2)
        assert relative_log_density(squared, tail, 2) == pytest.approx(math.log(density_there))
