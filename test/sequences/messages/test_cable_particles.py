from __future__ import annotations

import numpy as np
from message_parts import FACTORY, HEADER

from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.messages.cable_particles import (
    cloud_of,
    make_particles,
    read_particles,
)


def test_particles_are_kept_as_float32(sent):
    states = np.random.default_rng(0).normal(size=(50, 8))
    cloud = cloud_of(Particles.equally_weighted(states))
    message = sent(make_particles(FACTORY, HEADER, cloud))
    np.testing.assert_allclose(read_particles(message), cloud, rtol=1e-6)
    assert [field.name for field in message.fields] == [
        "x", "y", "z", "d", "alpha", "w", "beta", "v_d", "v_alpha", "v_w", "v_beta", "weight",
    ]  # fmt: skip
    assert (message.width, message.point_step, message.row_step) == (50, 48, 2400)
    points = np.frombuffer(message.data, "<f4").reshape(50, 12)
    np.testing.assert_allclose(points[:, 0], states[:, 0] * np.cos(states[:, 1]), rtol=1e-5)
    np.testing.assert_allclose(points[:, 1], states[:, 0] * np.sin(states[:, 1]), rtol=1e-5)
