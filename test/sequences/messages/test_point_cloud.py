from __future__ import annotations

import numpy as np
from message_parts import FACTORY

from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.point_cloud import make_point_cloud, read_point_cloud


def test_points_are_kept_as_float32(sent):
    points = np.array([[1.0, 0.1, -3.5], [4.0, 5.0, 6.0]])
    message = sent(make_point_cloud(FACTORY, make_header(FACTORY, 5, "camera"), "abc", points))
    assert [(field.name, field.offset) for field in message.fields] == [
        ("a", 0),
        ("b", 4),
        ("c", 8),
    ]
    np.testing.assert_array_equal(read_point_cloud(message, "abc"), points.astype(np.float32))


def test_a_cloud_may_be_empty(sent):
    points = np.empty((0, 3))
    message = sent(make_point_cloud(FACTORY, make_header(FACTORY, 5, "camera"), "abc", points))
    assert read_point_cloud(message, "abc").shape == (0, 3)
