import math

import numpy as np
import pytest

from cable_tracker.particle_filter.student_t import kernel_mixture
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.predicted_density import BIRTH_TAIL, Births, kernels_of, log_mix
from cable_tracker.target.model.state import STATE_SIZE
from cable_tracker.tracking.rates import share_about_last_place

LAST = np.array([60.0, -20.0, 0.1, 0.2, 5.0, 5.0])
SHARE = 0.6
"""Share of the births about it."""


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


@pytest.mark.parametrize("seconds", [0.0, 3.0, 60.0])
def test_births_integrate_what_their_draws_show(seconds):
    last = np.zeros(STATE_SIZE)
    births = Births(last, seconds, (240, 320))
    states = np.zeros((3, STATE_SIZE))
    states[1, 0], states[2, 0] = 40.0, 1000.0
    place, scale, angle = births._spreads()
    squared = (states[:, 0] / place) ** 2
    near = student(squared, BIRTH_TAIL, 4) - math.log(place * place * scale * angle)
    anywhere = student(np.zeros(3), BIRTH_TAIL, 2) - math.log(scale * angle * 320 * 240)
    anywhere[2] = -math.inf
    share = share_about_last_place(seconds, 4.0)
    literal = np.log(share * np.exp(near) + (1.0 - share) * np.exp(anywhere))
    assert births.log_density(states, share) == pytest.approx(literal)


def test_the_density_is_that_of_the_draws():
    births = Births(LAST, 0.5, (240, 320))
    drawn = births.draw(20_000, SHARE, np.random.default_rng(1))
    # Importance weights against a wide box of known volume average to its share of the mass.
    box = np.array([[-100.0, -80.0, -0.5, -0.5], [100.0, 80.0, 0.7, 0.9]])
    inside = ((drawn[:, :4] > box[0]) & (drawn[:, :4] < box[1])).all(axis=1).mean()
    points = np.zeros((200_000, 6))
    points[:, :4] = np.random.default_rng(2).uniform(box[0], box[1], (200_000, 4))
    mass = np.exp(births.log_density(points, SHARE)).mean() * np.prod(box[1] - box[0])
    # Without knowledge of the place, scale and angle have the same heavy tails together.
    assert mass == pytest.approx(inside, rel=0.05)


def test_the_longer_it_is_gone_the_farther_it_is_looked_for():
    rng = np.random.default_rng(3)
    soon, late = Births(LAST, 0.0, (240, 320)), Births(LAST, 0.0, (240, 320)).aged(3.0)
    spreads = [np.median(np.abs(each.draw(4000, SHARE, rng)[:, 0] - 60.0)) for each in (soon, late)]
    assert spreads[1] > 2.0 * spreads[0]


@pytest.mark.parametrize(("shift", "expected"), [(90.0, 150.0), (110.0, 60.0), (-230.0, 60.0)])
def test_the_last_place_turns_with_the_camera_within_the_picture(shift, expected):
    homography = np.eye(3)
    homography[0, 2] = shift
    turned = Births(LAST, 0.5, (240, 320)).moved(CameraMotion(homography), 1.0)
    assert turned.last == pytest.approx([expected, *LAST[1:]])


@pytest.mark.parametrize("turns", [-2, 1])
def test_whole_turns_make_no_difference(turns):
    births = Births(LAST, 0.5, (240, 320))
    states = births.draw(50, SHARE, np.random.default_rng(4))
    states[:, 3] = LAST[3] + np.linspace(-3.0, 3.0, 50)
    turned = states + np.array([0.0, 0.0, 0.0, turns * 2.0 * np.pi])
    expected = births.log_density(states, SHARE)
    assert births.log_density(turned, SHARE) == pytest.approx(expected, rel=1e-9)
