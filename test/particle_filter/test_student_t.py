from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.particle_filter.student_t import (
    StudentT,
    standard_student_t,
    student_t_log_density,
)

TAILS = [1.0, 2.5, 4.0, 30.0, math.inf]
COUNT = 40_000


def integral(values, places) -> float:
    """By the trapezoidal rule."""
    return float(np.sum((values[1:] + values[:-1]) / 2 * np.diff(places)))


def tilted(tail) -> StudentT:
    return StudentT(np.array([3.0, -1.0]), np.array([[2.0, 0.0], [1.5, 0.5]]), tail)


@pytest.mark.parametrize("tail", TAILS)
def test_the_density_integrates_to_one(tail):
    # On a line that is bent so that even a Cauchy tail fits: x = tan(u).
    u = np.linspace(-np.pi / 2, np.pi / 2, 20_001)[1:-1]
    x = np.tan(u)
    density = StudentT(np.zeros(1), np.full((1, 1), 0.7), tail).log_density(x[:, None])
    assert integral(np.exp(density) * (1 + x**2), u) == pytest.approx(1.0, abs=1e-3)


@given(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))
def test_many_degrees_of_freedom_are_nearly_gaussian(x, y):
    point = np.array([[x, y]])
    many, gaussian = tilted(1e7).log_density(point), tilted(math.inf).log_density(point)
    np.testing.assert_allclose(many, gaussian, rtol=1e-4, atol=1e-3)


def test_a_gaussian_and_a_cauchy_density_worked_by_hand():
    squared = np.array([0.0, 1.0, 9.0])
    gaussian = student_t_log_density(squared, 1, math.inf, 0.0)
    np.testing.assert_allclose(np.exp(gaussian), [0.398942, 0.241971, 0.00443185], rtol=1e-5)
    cauchy = student_t_log_density(squared, 1, 1.0, math.log(2.0))
    np.testing.assert_allclose(np.exp(cauchy), 1 / (2 * np.pi * (1 + squared)))


@pytest.mark.parametrize("tail", TAILS)
def test_draws_have_the_quantiles_of_the_density(tail, draw_standard):
    draws = draw_standard(COUNT, 1, tail)[:, 0]
    x = np.linspace(-2.0, 2.0, 4001)
    density = np.exp(student_t_log_density(x**2, 1, tail, 0.0))
    assert (np.abs(draws) < 2.0).mean() == pytest.approx(integral(density, x), abs=0.012)
    assert (draws < 0).mean() == pytest.approx(0.5, abs=0.012)


@pytest.mark.parametrize("tail", [5.0, math.inf])
def test_draws_have_the_location_and_the_scale(tail, draw_standard):
    distribution = tilted(tail)
    draws = distribution.placed(draw_standard(COUNT, 2, tail))
    assert draws.shape == (COUNT, 2)
    np.testing.assert_allclose(draws.mean(axis=0), distribution.location, atol=0.07)
    scale = distribution.factor @ distribution.factor.T
    variance = scale * (tail / (tail - 2.0) if math.isfinite(tail) else 1.0)
    np.testing.assert_allclose(np.cov(draws.T), variance, rtol=0.12)


@pytest.mark.parametrize("tail", TAILS)
def test_draws_agree_with_the_density(tail, draw_standard):
    """The mean of g / density over draws is the integral of g: here a box of area 2."""
    distribution = tilted(tail)
    draws = distribution.placed(draw_standard(COUNT, 2, tail))
    in_box = (np.abs(draws[:, 0] - 3.0) < 1.0) & (np.abs(draws[:, 1] + 1.0) < 0.5)
    ratios = in_box / np.exp(distribution.log_density(draws))
    standard_error = ratios.std() / np.sqrt(COUNT)
    assert ratios.mean() == pytest.approx(2.0, abs=5 * standard_error)
    assert standard_error < 0.2


def test_no_draws_are_no_problem(rng):
    assert standard_student_t(rng, 0, 3, 4.0).shape == (0, 3)
