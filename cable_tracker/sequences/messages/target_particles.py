"""Particles of a target, in the image frame: origin at the image centre, x right, y up [px]."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.sequences.messages.point_cloud import make_point_cloud, read_point_cloud
from cable_tracker.target.model.state import PoseColumn

TARGET_CLOUD_COLUMNS = ("x", "y", "z", "scale", "angle", "v_x", "v_y", "weight")


def make_target_particles(
    factory: MessageFactory, header: Message, particles: Particles
) -> Message:
    """Pack poses as a PointCloud2 of float32.

    Fields x, y [px], z = 0, scale (against the start), angle [rad], v_x, v_y [px/s], weight
    (summing to one).
    """
    states = particles.states
    points = np.column_stack(
        (
            states[:, PoseColumn.X], states[:, PoseColumn.Y], np.zeros(len(states)),
            np.exp(states[:, PoseColumn.LOG_SCALE]), states[:, PoseColumn.ANGLE],
            states[:, PoseColumn.X_RATE], states[:, PoseColumn.Y_RATE], particles.weights,
        )
    )  # fmt: skip
    return make_point_cloud(factory, header, TARGET_CLOUD_COLUMNS, points)


def read_target_particles(message: Message) -> FloatArray | None:
    """Read particles packed by `make_target_particles`.

    Returns
    -------
    FloatArray or None
        Columns x, y [px], scale, angle [rad], v_x, v_y [px/s], weight, shape (N, 7); None if there
        are none.
    """
    table = read_point_cloud(message, TARGET_CLOUD_COLUMNS)
    return np.delete(table, TARGET_CLOUD_COLUMNS.index("z"), axis=1) if len(table) else None
