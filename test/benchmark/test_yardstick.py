import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.benchmark.yardstick import yardstick_of
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.observation import BorderObservation

THESIS = preset("thesis").replaced({"kernels": "numpy"})


def observed(image, states):
    working = make_working_image(image, THESIS.working_width, THESIS.filter_sigma)
    return np.exp(BorderObservation(THESIS).log_likelihoods(states, working))


def test_it_gives_the_weights_of_the_observation_of_the_thesis(shown, yardstick):
    weights = yardstick()
    assert len(weights) == 500
    assert np.median(weights) > 10.0
    np.testing.assert_allclose(weights, observed(shown.images[0], yardstick.states), rtol=1e-4)


@settings(max_examples=50, deadline=None)
@given(
    d=st.floats(-250.0, 250.0),
    alpha=st.floats(-1.6, 1.6),
    w=st.floats(4.0, 160.0),
    beta=st.floats(-0.3, 0.3),
)
def test_it_agrees_wherever_the_cable_is(shown, d, alpha, w, beta):
    states = np.array([[d, alpha, w, beta, 0.0, 0.0, 0.0, 0.0]])
    weights = yardstick_of(shown.images[0], states, THESIS)()
    np.testing.assert_allclose(weights, observed(shown.images[0], states), rtol=1e-3, atol=2e-3)


def test_borders_that_do_not_oppose_each_other_weigh_epsilon(yardstick):
    flat = yardstick_of(np.full((240, 320), 90, np.uint8), yardstick.states, THESIS)
    assert flat() == pytest.approx(THESIS.epsilon)


def test_it_reads_four_pixels_for_each_tap_of_each_point(yardstick):
    assert yardstick.pixels_touched() == 500 * 2 * 21 * 11 * 4
