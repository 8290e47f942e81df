import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.benchmark import cases
from cable_tracker.benchmark.cases import (
    FilterSteps,
    points_of_a_cable,
    rival_cases,
    sample_points,
    snapshot_after,
    spacing_cases,
)
from cable_tracker.benchmark.footage import footage
from cable_tracker.cable.model.geometry import project_borders, segment_inside
from cable_tracker.cable.parameters.presets import preset


def test_what_the_filter_reads_of_a_picture_is_worked_out_anew_at_every_call(shown):
    steps = FilterSteps(preset("default"), shown).preprocessing_steps()
    assert steps
    kept = [(step(), step()) for step in steps.values()]
    assert any(first is not second for first, second in kept if not isinstance(first, float))


def test_a_library_that_is_absent_is_left_out(shown, monkeypatch):
    monkeypatch.setattr(cases, "is_installed", lambda name: name == "filterpy")
    names = [each.label.name for each in rival_cases(shown)]
    assert "filterpy" in names
    assert "particles" not in names


def test_half_the_spacing_is_twice_the_points(shown):
    assert points_of_a_cable(shown, 5.0) == pytest.approx(
        2 * points_of_a_cable(shown, 10.0), rel=0.1
    )
    amounts = [each.label.amount for each in spacing_cases(shown)]
    assert amounts[:4] == sorted(amounts[:4], reverse=True)


def test_points_do_not_depend_on_the_size_of_the_frame(shown):
    large = footage(len(shown.images), (640, 480))
    assert points_of_a_cable(large, 10.0) == pytest.approx(points_of_a_cable(shown, 10.0), rel=0.02)


def test_particles_are_about_the_cable(shown):
    particles = snapshot_after(preset("thesis"), shown, 3).particles
    mean = particles.weights @ particles.states
    assert math.isclose(float(np.sum(particles.weights)), 1.0)
    assert mean[0] == pytest.approx(shown.truths[2].distance, abs=10.0)


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
