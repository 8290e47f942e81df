from __future__ import annotations

import numpy as np
from message_parts import FACTORY, HEADER

from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.messages.point_cloud import make_point_cloud
from cable_tracker.sequences.messages.target_particles import (
    TARGET_CLOUD_COLUMNS,
    make_target_particles,
    read_target_particles,
)


def test_particles_are_kept_with_their_scale(sent):
    states = np.array([[1.0, 2.0, np.log(2.0), 0.5, 3.0, 4.0]])
    message = make_target_particles(FACTORY, HEADER, Particles.equally_weighted(states))
    found = read_target_particles(sent(message))
    assert found.tolist() == [[1.0, 2.0, 2.0, 0.5, 3.0, 4.0, 1.0]]


def test_a_cloud_without_particles_is_none(sent):
    columns = len(TARGET_CLOUD_COLUMNS)
    message = make_point_cloud(FACTORY, HEADER, TARGET_CLOUD_COLUMNS, np.empty((0, columns)))
    assert read_target_particles(sent(message)) is None
