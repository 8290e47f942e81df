import numpy as np
import pytest

from cable_tracker.target.thesis.weights import blob_weights

IMAGE, SHAPE = np.array([0.002, 0.001, np.inf, 0.004]), np.array([4.0, 1.0, np.inf, 9.0])
CONTRAST = np.array([0.3, 0.5, 0.0, 0.2])


@pytest.mark.parametrize("form", ["eq30", "product", "likelihood_ratio"])
def test_weights_sum_to_one_and_prefer_the_better(form):
    weights = blob_weights(IMAGE, SHAPE, CONTRAST, form)
    assert weights.sum() == pytest.approx(1.0)
    assert np.argmax(weights) == 1
    assert weights[2] == 0.0


def test_equation_30_gives_the_image_about_one_nth_of_the_mass():
    count = 50
    image, shape = np.zeros(count), np.ones(count)
    image[0] = 5.0
    weights = blob_weights(image, shape, np.ones(count), "eq30")
    assert weights[0] == pytest.approx(weights[1], rel=0.03)


def test_without_any_contour_all_are_equal():
    nothing = np.full(4, np.inf)
    assert blob_weights(nothing, nothing, np.zeros(4), "product") == pytest.approx([0.25] * 4)
