from __future__ import annotations

import numpy as np

from cable_tracker.simulation.rendering.world_frame import from_renderer, to_renderer

VECTORS = np.random.default_rng(1).normal(size=(2, 4, 3))


def test_along_and_to_the_left_are_the_axes_of_the_vehicle():
    along, right = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    assert from_renderer(along).tolist() == [1.0, 0.0, 0.0]
    assert from_renderer(right).tolist() == [0.0, -1.0, 0.0]


def test_there_and_back_loses_no_bit():
    np.testing.assert_array_equal(to_renderer(from_renderer(VECTORS)), VECTORS)
