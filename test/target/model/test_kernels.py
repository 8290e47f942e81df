import math

import numpy as np
import pytest

from cable_tracker.particle_filter.student_t import kernel_mixture
from cable_tracker.target.model.births import TAIL, Births
from cable_tracker.target.model.predicted_density import choose_columns, kernels_of, log_mix
from cable_tracker.target.model.state import STATE_SIZE
from cable_tracker.tracking.rates import share_about_last_place


def student(squared, tail, dimensions):
    """Log-density of a Student-t distribution for a unit scale, written out."""
    peak = math.lgamma((tail + dimensions) / 2) - math.lgamma(tail / 2)
    peak -= 0.5 * dimensions * math.log(tail * math.pi)
    return peak - 0.5 * (tail + dimensions) * np.log1p(squared / tail)


@pytest.mark.parametrize("tail", [3.0, 4.0, 30.0])
def test_mixtures_have_the_density_that_their_formula_says(tail):
    rng = np.random.default_rng(1)
    places, points = rng.normal(0.0, 2.0, (5, 4)), rng.normal(0.0, 3.0, (7, 4))
    scales, weights = np.array([1.0, 2.0, 0.5, 0.3]), np.array([0.1, 0.3, 0.2, 0.15, 0.25])
    mixture = kernel_mixture(places, scales, tail, weights)
    offsets = (points[:, None] - places[None]) / scales
    logs = student((offsets**2).sum(axis=2), tail, 4) - np.log(scales.prod())
    literal = np.log((np.exp(logs) * weights).sum(axis=1))
    assert log_mix(kernels_of(points, mixture), weights, mixture) == pytest.approx(literal)


def test_columns_are_chosen_by_their_shares():
    values = np.tile([1.0, 2.0, 0.0, 1.0], (4, 1))
    chosen = choose_columns(values, np.array([0.0, 0.26, 0.74, 0.99]))
    assert list(chosen) == [0, 1, 1, 3]


@pytest.mark.parametrize("seconds", [0.0, 3.0, 60.0])
def test_births_integrate_what_their_draws_show(seconds):
    last = np.zeros(STATE_SIZE)
    births = Births(last, seconds, (240, 320))
    states = np.zeros((3, STATE_SIZE))
    states[1, 0], states[2, 0] = 40.0, 1000.0
    place, scale, angle = births._spreads()
    squared = (states[:, 0] / place) ** 2
    near = student(squared, TAIL, 4) - math.log(place * place * scale * angle)
    anywhere = student(np.zeros(3), TAIL, 2) - math.log(scale * angle * 320 * 240)
    anywhere[2] = -math.inf
    share = share_about_last_place(seconds, 4.0)
    literal = np.log(share * np.exp(near) + (1.0 - share) * np.exp(anywhere))
    assert births.log_density(states, share) == pytest.approx(literal)
