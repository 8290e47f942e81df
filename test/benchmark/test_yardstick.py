import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.benchmark.cases import sample_points
from cable_tracker.benchmark.yardstick import TAPS, derivative_of_gaussian, yardstick_of
from cable_tracker.cable.model.geometry import project_borders
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.border_response_model import response_weights
from cable_tracker.tracking.image_frame import image_to_pixel

THESIS = preset("thesis")


def observed(image, states):
    """Weigh cables by vectors: all points, all taps, read by OpenCV, which knows 1/32 px."""
    borders, size = project_borders(states), (image.shape[1], image.shape[0])
    points, inside = sample_points(borders, THESIS.sample_spacing, size)
    kernel = derivative_of_gaussian(TAPS, THESIS.filter_sigma)
    reach = np.arange(TAPS) - (TAPS - 1) / 2
    pixels = image_to_pixel(points, size)
    columns = pixels[..., 0, None] + reach * np.cos(borders.angles)[..., None, None]
    rows = pixels[..., 1, None] - reach * np.sin(borders.angles)[..., None, None]
    flat = (np.float32(each.reshape(len(states), -1)) for each in (columns, rows))
    levels = cv2.remap(np.float32(image), *flat, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    responses = levels.reshape(rows.shape) @ kernel
    return response_weights((responses * inside).sum(axis=2), THESIS.epsilon)


def test_it_gives_the_weights_of_the_observation_of_the_thesis(shown, yardstick):
    weights = yardstick()
    assert len(weights) == 500
    assert np.median(weights) > 10.0
    np.testing.assert_allclose(weights, observed(shown.images[0], yardstick.states), rtol=0.02)


@settings(max_examples=50)
@given(
    d=st.floats(-250.0, 250.0),
    alpha=st.floats(-1.6, 1.6),
    w=st.floats(4.0, 160.0),
    beta=st.floats(-0.3, 0.3),
)
def test_it_agrees_wherever_the_cable_is(shown, d, alpha, w, beta):
    states = np.array([[d, alpha, w, beta, 0.0, 0.0, 0.0, 0.0]])
    weights = yardstick_of(shown.images[0], states, THESIS)()
    np.testing.assert_allclose(weights, observed(shown.images[0], states), rtol=0.05, atol=3.0)


def test_borders_that_do_not_oppose_each_other_weigh_epsilon(yardstick):
    flat = yardstick_of(np.full((240, 320), 90, np.uint8), yardstick.states, THESIS)
    assert flat() == pytest.approx(THESIS.epsilon)


def test_it_reads_four_pixels_for_each_tap_of_each_point(yardstick):
    assert yardstick.pixels_touched() == 500 * 2 * 21 * 11 * 4
