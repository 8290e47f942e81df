"""Particles of a cable."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import STATE_SYMBOLS, StateColumn
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.sequences.messages.point_cloud import make_point_cloud, read_point_cloud

CLOUD_COLUMNS = ("x", "y", "z", *STATE_SYMBOLS, "weight")


def cloud_of(particles: Particles) -> FloatArray:
    """Return the eight state columns and the weight of each particle, shape (N, 9)."""
    return np.column_stack((particles.states, particles.weights))


def make_particles(factory: MessageFactory, header: Message, cloud: FloatArray) -> Message:
    """Pack particles (N, 9) as a PointCloud2 of float32.

    Fields x, y, z (foot point [px], z = 0, for rviz), d, alpha, w, beta, v_d, v_alpha, v_w, v_beta
    [px, rad, per second], weight (summing to one).
    """
    distance, angle = cloud[:, StateColumn.DISTANCE], cloud[:, StateColumn.ANGLE]
    points = np.column_stack(
        (distance * np.cos(angle), distance * np.sin(angle), np.zeros(len(cloud)), cloud)
    )
    return make_point_cloud(factory, header, CLOUD_COLUMNS, points)


def read_particles(message: Message) -> FloatArray:
    """Read particles packed by `make_particles`; shape (N, 9)."""
    return read_point_cloud(message, CLOUD_COLUMNS)[:, 3:]
