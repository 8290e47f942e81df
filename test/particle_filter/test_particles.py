from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.particle_filter.particles import Particles


@pytest.fixture
def particles() -> Particles:
    return Particles(np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]), np.log([0.5, 0.3, 0.2]))


def test_weights_of_equally_weighted_particles_are_equal_and_sum_to_one():
    particles = Particles.equally_weighted(np.zeros((4, 2)))
    assert particles.count == 4
    np.testing.assert_allclose(particles.weights, 0.25)


@pytest.mark.parametrize(
    ("states", "log_weights"),
    [
        (np.zeros((0, 2)), np.zeros(0)),
        (np.zeros(3), np.zeros(3)),
        (np.zeros((3, 2)), np.zeros(2)),
        (np.zeros((3, 2)), np.zeros((3, 1))),
    ],
)
def test_shapes_that_do_not_belong_together_are_refused(states, log_weights):
    with pytest.raises(ValueError, match="shape"):
        Particles(states, log_weights)


def test_moving_keeps_the_weights(particles):
    moved = particles.moved_to(particles.states + 1.0)
    np.testing.assert_array_equal(moved.weights, particles.weights)
    np.testing.assert_array_equal(moved.states, particles.states + 1.0)


def test_likelihoods_multiply_the_weights(particles):
    posterior = particles.reweighted(np.log([0.1, 0.2, 0.4]))
    np.testing.assert_allclose(posterior.weights, np.array([0.05, 0.06, 0.08]) / 0.19)


@pytest.mark.parametrize("value", [-np.inf, np.nan])
def test_an_observation_that_excludes_everything_changes_nothing(particles, value):
    assert particles.reweighted(np.full(3, value)) is particles


def test_particles_of_nan_likelihood_drop_out(particles):
    posterior = particles.reweighted(np.array([0.0, np.nan, 0.0]))
    np.testing.assert_allclose(posterior.weights, [5 / 7, 0.0, 2 / 7])


def test_a_weight_of_zero_times_an_infinite_likelihood_is_zero():
    particles = Particles(np.zeros((3, 1)), np.array([-np.inf, np.log(0.5), np.log(0.5)]))
    posterior = particles.reweighted(np.array([np.inf, 0.0, np.log(3.0)]))
    np.testing.assert_allclose(posterior.weights, [0.0, 0.25, 0.75])


def test_likelihoods_of_another_number_of_particles_are_refused(particles):
    with pytest.raises(ValueError, match="shape"):
        particles.reweighted(np.zeros((3, 1)))


def test_selected_particles_weigh_the_same(particles):
    selected = particles.selected(np.array([2, 2, 0, 1]))
    np.testing.assert_array_equal(selected.states[:, 0], [5.0, 5.0, 1.0, 3.0])
    np.testing.assert_allclose(selected.weights, 0.25)
