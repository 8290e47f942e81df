from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.benchmark.sample_points import sample_points
from cable_tracker.cable.model.geometry import project_borders, segment_inside

SIZE = (320, 240)

cables = st.tuples(
    st.floats(-400, 400), st.floats(-10, 10), st.floats(0.5, 300), st.floats(-1.2, 1.2)
).map(lambda pose: np.array([pose]))
"""d, alpha, w, beta, shape (1, 4)."""


@given(cables, st.floats(3.0, 40.0))
def test_sample_points_lie_on_the_border_at_equal_distances(poses, spacing):
    borders = project_borders(poses)
    points, inside = sample_points(borders, spacing, SIZE)
    assert points.shape == (1, 2, inside.shape[2], 2)
    for side in (0, 1):
        angle, offset = borders.angles[0, side], borders.offsets[0, side]
        distances = points[0, side] @ [np.cos(angle), np.sin(angle)] - offset
        np.testing.assert_allclose(distances, 0.0, atol=1e-8)
        steps = np.linalg.norm(np.diff(points[0, side], axis=0), axis=1)
        np.testing.assert_allclose(steps, spacing)
        x, y = points[0, side].T
        expected = (np.abs(x) <= 159.5) & (np.abs(y) <= 119.5)
        np.testing.assert_array_equal(inside[0, side], expected)


@given(cables)
def test_no_stretch_of_a_border_inside_the_image_goes_without_points(poses):
    borders = project_borders(poses)
    _, inside = sample_points(borders, 10.0, SIZE)
    for side in (0, 1):
        segment = segment_inside(borders.angles[0, side], borders.offsets[0, side], SIZE)
        length = 0.0 if segment is None else np.linalg.norm(np.subtract(*segment))
        assert inside[0, side].sum() >= np.floor(length / 10.0 - 1e-6)
        assert inside[0, side].sum() <= length / 10.0 + 1 + 1e-6
