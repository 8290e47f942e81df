from __future__ import annotations

import numpy as np

from cable_tracker.simulation.rendering.world_frame import (
    angles_from_renderer,
    angles_to_renderer,
    from_renderer,
    to_renderer,
)

VECTORS = np.random.default_rng(1).normal(size=(2, 4, 3))


def test_along_and_to_the_left_are_the_axes_of_the_vehicle():
    along, right = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    assert from_renderer(along).tolist() == [1.0, 0.0, 0.0]
    assert from_renderer(right).tolist() == [0.0, -1.0, 0.0]


def test_a_raised_nose_is_a_negative_pitch_of_the_vehicle():
    assert angles_from_renderer(np.array([0.3, 0.2, 0.1])).tolist() == [0.1, -0.2, 0.3]


def test_there_and_back_loses_no_bit():
    np.testing.assert_array_equal(to_renderer(from_renderer(VECTORS)), VECTORS)
    np.testing.assert_array_equal(angles_to_renderer(angles_from_renderer(VECTORS)), VECTORS)
