from __future__ import annotations

import dataclasses
import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.metric.calibration import Calibration, CameraModel, camera_for
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.tracking.image_frame import image_to_pixel

SIZE = (320, 240)
GRID = np.stack(np.meshgrid(np.linspace(-159.5, 159.5, 9), np.linspace(-119.5, 119.5, 7)), -1)
PLAIN = Calibration(SIZE, "plumb_bob", (280.0, 275.0), (163.0, 117.0))


def test_rays_are_projected_back_to_their_pixels(calibration, camera_of):
    camera = camera_of(calibration)
    rays = camera.rays(GRID)
    assert rays.shape == (7, 9, 3)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1.0)
    np.testing.assert_allclose(camera.project(rays), GRID, atol=1e-3)


def test_the_lens_is_that_of_opencv(calibration, camera_of):
    camera = camera_of(calibration)
    rays = camera.rays(GRID).reshape(-1, 1, 3)
    lens = np.array(calibration.coefficients or (0.0,) * 4)
    project = cv2.fisheye.projectPoints if calibration.model == "equidistant" else None
    zero = np.zeros((3, 1))
    if project is None:
        pixels, _ = cv2.projectPoints(rays, zero, zero, camera.matrix, lens)
    else:
        pixels, _ = project(rays, zero, zero, camera.matrix, lens)
    expected = image_to_pixel(GRID, SIZE).reshape(-1, 2)
    np.testing.assert_allclose(pixels.reshape(-1, 2), expected, atol=1e-3)


def test_the_optical_axis_is_seen_at_the_principal_point(calibration, camera_of):
    point = camera_of(calibration).project(np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(image_to_pixel(point, SIZE), calibration.centre)


def test_up_in_the_image_is_minus_y_of_the_optical_frame(camera_of):
    right, up = camera_of(PLAIN).rays(np.array([[100.0, 0.0], [0.0, 100.0]]))
    assert right[0] > 0.3 and up[1] < -0.3


def test_without_a_lens_the_image_matrix_projects(camera_of):
    camera = camera_of(PLAIN)
    rays = camera.rays(GRID).reshape(-1, 3)
    seen = rays @ camera.image_matrix.T
    np.testing.assert_allclose(seen[:, :2] / seen[:, 2:], GRID.reshape(-1, 2), atol=1e-9)


def test_a_fisheye_sees_beside_and_behind(camera_of):
    wide = dataclasses.replace(
        PLAIN, model="equidistant", focal=(80.0, 80.0), coefficients=(0.0, 0.0, 0.0, 0.0)
    )
    camera = camera_of(wide)
    aside = camera.rays(np.array([150.0, -2.5]))
    assert math.degrees(math.acos(aside[2])) > 100.0
    np.testing.assert_allclose(camera.project(aside), [150.0, -2.5], atol=1e-3)


def test_a_pinhole_sees_nothing_behind_it(camera_of):
    assert np.isnan(camera_of(PLAIN).project(np.array([0.1, 0.0, -1.0]))).all()


def test_where_the_lens_folds_there_is_no_ray(camera_of):
    folding = dataclasses.replace(PLAIN, coefficients=(-1.2, 0.0, 0.0, 0.0))
    rays = camera_of(folding).rays(np.array([[0.0, 0.0], [159.0, 119.0]]))
    assert np.isfinite(rays[0]).all() and np.isnan(rays[1]).all()


@given(scale=st.sampled_from([0.25, 0.5, 1.5, 2.0, 4.0]))
def test_a_calibration_of_another_size_is_scaled(scale):
    size = (int(320 * scale), int(240 * scale))
    small, other = (camera_for(PLAIN, each) for each in (SIZE, size))
    assert isinstance(small, CameraModel) and isinstance(other, CameraModel)
    np.testing.assert_allclose(other.rays(GRID * scale), small.rays(GRID), atol=1e-9)


def test_a_region_of_the_image_sees_what_it_saw(camera_of):
    cut = PLAIN.cut((40, 20), (200, 180))
    # The cut image's centre is the pixel (139.5, 109.5) of the whole one.
    shift = np.array([139.5 - 159.5, 119.5 - 109.5])
    np.testing.assert_allclose(
        camera_of(cut).rays(GRID / 2), camera_of(PLAIN).rays(GRID / 2 + shift), atol=1e-9
    )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"focal": (0.0, 0.0)}, "focal length is below 0.1 px"),
        ({"focal": (280.0, 1e-200)}, "focal length is below 0.1 px"),
        ({"centre": (159.5, 1e99)}, "as good as infinite"),
        ({"coefficients": (1e225, 0.0, 0.0, 0.0)}, "as good as infinite"),
        ({"focal": (math.nan, 280.0)}, "not finite"),
        ({"coefficients": (math.inf, 0.0, 0.0, 0.0)}, "not finite"),
        ({"image_size": (0, 0)}, "no image size"),
        ({"model": "thin_prism"}, "'thin_prism' is none of plumb_bob"),
        ({"coefficients": (0.1, 0.2, 0.3)}, "0 or 4 or 5 distortion coefficients, not 3"),
        ({"model": "rational_polynomial", "coefficients": (0.1,) * 5}, "not 5"),
    ],
)
def test_a_bad_calibration_is_refused(changes, words):
    refused = camera_for(dataclasses.replace(PLAIN, **changes), SIZE)
    assert isinstance(refused, Withheld)
    assert refused.reason is Reason.BAD_CALIBRATION
    assert words in refused.detail


def test_another_aspect_is_refused_with_both_sizes():
    refused = camera_for(PLAIN, (640, 360))
    assert isinstance(refused, Withheld)
    assert refused.reason is Reason.OTHER_IMAGE_SIZE
    assert "320x240" in refused.detail and "640x360" in refused.detail


def test_a_camera_info_becomes_a_calibration():
    k = [280.0, 0.0, 163.0, 0.0, 275.0, 117.0, 0.0, 0.0, 1.0]
    assert Calibration.of_matrices(SIZE, "plumb_bob", k, []) == PLAIN


@pytest.mark.parametrize("kind", [list, np.array])
def test_a_calibration_of_lists_or_arrays_is_that_of_tuples(kind):
    # OpenCV returns the coefficients as a row.
    row = kind([[0.1, 0.01, 0.0, 0.0, 0.0]])
    given = Calibration(kind(SIZE), "plumb_bob", kind((280.0, 275.0)), kind((163.0, 117.0)), row)
    plain = dataclasses.replace(PLAIN, coefficients=(0.1, 0.01, 0.0, 0.0, 0.0))
    assert given == plain
    assert camera_for(given, SIZE) == camera_for(plain, SIZE)


def test_fisheye_is_another_name_of_equidistant():
    camera = camera_for(dataclasses.replace(PLAIN, model="fisheye"), SIZE)
    assert isinstance(camera, CameraModel)
    assert camera.model.value == "equidistant"
