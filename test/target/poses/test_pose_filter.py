import numpy as np
import pytest

from cable_tracker.particle_filter.particles import Particles
from cable_tracker.target.poses.pose_filter import cluster_weights, crowding_costs


def poses(*centres):
    states = np.zeros((len(centres), 6))
    states[:, :2] = centres
    return states


def test_to_be_where_another_target_is_costs_most_there():
    states, others = poses((0, 0), (10, 0), (1000, 0)), poses((0, 0))
    expected = [3.0, 3.0 * np.exp(-0.5), 0.0]
    assert crowding_costs(states, others, 3.0, 10.0) == pytest.approx(expected)


def test_without_others_nothing_is_crowded():
    assert (crowding_costs(poses((0, 0), (1, 1)), np.empty((0, 6)), 3.0, 10.0) == 0.0).all()


def test_only_particles_about_the_best_one_make_the_estimate():
    particles = Particles(poses((0, 0), (5, 0), (50, 0)), np.log([0.5, 0.25, 0.25]))
    assert cluster_weights(particles, 10.0) == pytest.approx([2 / 3, 1 / 3, 0.0])
