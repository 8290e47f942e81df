from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.simulation.rendering.camera import (
    Camera,
    from_renderer,
    rotation_about,
    to_renderer,
)

SIZE = (320, 240)
PLUMB_BOB = (-0.25, 0.08, 0.001, -0.002, 0.0)

VECTORS = np.random.default_rng(1).normal(size=(2, 4, 3))


def _vehicle(x=0.0, y=0.0, z=2.0, *, yaw=0.0, pitch=0.0, roll=0.0):
    """A vehicle whose nose is raised by `pitch`, which REP 103 counts as negative."""
    return np.array([[x, y, z]]), np.array([[roll, -pitch, yaw]])


def _project(camera, vehicle, point):
    seen = camera.poses(*vehicle).to_camera(np.array([[point]]))
    return camera.project(seen)[0, 0]


@pytest.mark.parametrize(
    ("vehicle", "point", "expected"),
    [
        (_vehicle(), (0.5, 0.25, 0.0), (70.0, 35.0)),
        (_vehicle(x=0.5), (0.5, 0.25, 0.0), (0.0, 35.0)),
        (_vehicle(yaw=np.pi / 2), (-0.5, 0.0, 0.0), (0.0, 70.0)),
        (_vehicle(pitch=np.pi / 4), (0.0, 2.0, 0.0), (0.0, 0.0)),
        (_vehicle(roll=np.pi / 4), (-2.0, 0.0, 0.0), (0.0, 0.0)),
    ],
    ids=["down", "aside", "turned left", "nose up", "right side down"],
)
def test_points_are_projected_by_hand(vehicle, point, expected):
    assert _project(Camera(SIZE, 280.0), vehicle, point) == pytest.approx(expected, abs=1e-9)


def test_a_mounting_looks_forward_like_a_raised_nose():
    mounted = _project(Camera(SIZE, 280.0, mounting=0.3), _vehicle(), (0.3, 1.0, 0.0))
    raised = _project(Camera(SIZE, 280.0), _vehicle(pitch=0.3), (0.3, 1.0, 0.0))
    assert mounted == pytest.approx(raised)


@given(*[st.floats(-1.2, 1.2) for _ in range(3)], st.floats(0.0, 1.0))
def test_vehicle_and_camera_poses_are_inverse(yaw, pitch, roll, mounting):
    camera = Camera(SIZE, 280.0, mounting)
    positions, angles = _vehicle(1.0, -2.0, 3.0, yaw=yaw, pitch=pitch, roll=roll)
    poses = camera.poses(positions, angles)
    np.testing.assert_allclose(camera.vehicle_angles(poses), angles, atol=1e-9)
    np.testing.assert_array_equal(poses.positions, positions)


@pytest.mark.parametrize("distortion", [(0.0,) * 5, PLUMB_BOB], ids=["straight", "bent"])
def test_rays_are_the_inverse_of_projection(distortion):
    camera = Camera((64, 48), 56.0, distortion=distortion)
    points = camera.project(np.moveaxis(camera.rays().astype(float), 0, -1))
    columns, rows = np.meshgrid(np.arange(64) - 31.5, 23.5 - np.arange(48))
    np.testing.assert_allclose(points[..., 0], columns, atol=1e-3)
    np.testing.assert_allclose(points[..., 1], rows, atol=1e-3)


@pytest.mark.parametrize(
    ("distortion", "sees_all"),
    [
        ((0.0,) * 5, True),
        (PLUMB_BOB, True),
        ((0.3, 0.0, 0.0, 0.0, 0.0), True),
        ((-2.0, 0.0, 0.0, 0.0, 0.0), False),
        ((math.inf, 0.0, 0.0, 0.0, 0.0), False),
    ],
)
def test_a_lens_that_folds_its_picture_is_told_from_one_that_shows_it_all(distortion, sees_all):
    assert Camera(SIZE, 280.0, distortion=distortion).sees_all_pixels() is sees_all


def test_distortion_is_that_of_opencv():
    camera = Camera(SIZE, 280.0, distortion=PLUMB_BOB)
    point = np.array([0.3, 0.2, -1.0])
    matrix = np.array([[280.0, 0, 159.5], [0, 280.0, 119.5], [0, 0, 1]])
    flipped = (point * (1, -1, -1)).reshape(1, 1, 3)
    pixel = cv2.projectPoints(flipped, np.zeros(3), np.zeros(3), matrix, np.array(PLUMB_BOB))[0]
    x, y = camera.project(point)
    assert (x + 159.5, 119.5 - y) == pytest.approx(tuple(pixel.ravel()), abs=1e-6)


def test_what_is_behind_the_camera_is_not_projected():
    assert np.isnan(Camera(SIZE, 280.0).project(np.array([0.1, 0.1, 0.5]))).all()


@given(st.integers(0, 2), st.floats(-7, 7))
def test_rotations_keep_their_axis_and_lengths(axis, angle):
    rotation = rotation_about(axis, np.array([angle]))[0]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert rotation[axis, axis] == 1.0
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_along_and_to_the_left_are_the_axes_of_the_vehicle():
    along, right = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    assert from_renderer(along).tolist() == [1.0, 0.0, 0.0]
    assert from_renderer(right).tolist() == [0.0, -1.0, 0.0]


def test_there_and_back_loses_no_bit():
    np.testing.assert_array_equal(to_renderer(from_renderer(VECTORS)), VECTORS)
