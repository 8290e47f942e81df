import numpy as np
import pytest

from cable_tracker.tracking.image_frame import (
    bounding_box,
    from_page,
    image_centre,
    image_to_pixel,
    pixel_to_image,
    to_image,
    to_page,
    to_pixel,
)

SIZE = (320, 240)
PLACES = [
    ((159.5, 119.5), (0.0, 0.0)),
    ((0.0, 0.0), (-159.5, 119.5)),
    ((319.0, 239.0), (159.5, -119.5)),
]
"""Column and row, and x and y of the same place."""


@pytest.mark.parametrize(("pixel", "point"), PLACES)
def test_pixel_coordinates_count_from_the_centre_of_the_top_left_pixel(pixel, point):
    assert to_pixel(*point, SIZE) == pixel
    assert to_image(*pixel, SIZE) == point


def test_points_of_any_shape_are_turned_like_single_ones():
    pixels, points = (np.array(each).reshape(3, 1, 2) for each in zip(*PLACES, strict=True))
    assert image_to_pixel(points, SIZE).tolist() == pixels.tolist()
    assert pixel_to_image(pixels, SIZE).tolist() == points.tolist()


def test_pixels_and_points_are_inverse_to_each_other():
    points, size = np.random.default_rng(1).uniform(-150, 150, (7, 2)), (321, 240)
    np.testing.assert_allclose(pixel_to_image(image_to_pixel(points, size), size), points)


def test_columns_and_rows_need_not_be_as_many():
    x, y = to_image(np.arange(3), np.arange(2), (3, 2))
    assert (x.tolist(), y.tolist()) == ([-1.0, 0.0, 1.0], [0.5, -0.5])


def test_the_centre_of_an_image_is_between_the_outermost_pixels():
    assert image_centre((321, 240)) == (160.0, 119.5)


def test_a_page_counts_from_the_corner_of_the_top_left_pixel():
    assert to_page(-160.0, 120.0, SIZE) == (0.0, 0.0)
    assert to_page(0.0, 0.0, SIZE) == (160.0, 120.0)
    assert from_page(*to_page(12.0, -7.0, SIZE), SIZE) == (12.0, -7.0)


def test_single_precision_stays():
    assert to_image(np.zeros(1, np.float32), np.zeros(1, np.float32), SIZE)[0].dtype == np.float32


def test_the_bounding_box_holds_the_first_and_the_last_pixels():
    mask = np.zeros((6, 9), bool)
    mask[2, 3] = mask[4, 7] = True
    assert bounding_box(mask) == (3, 2, 8, 5)


def test_an_empty_mask_has_no_bounding_box():
    assert bounding_box(np.zeros((6, 9), bool)) is None
