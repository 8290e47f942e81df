from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.picture.working_image import WorkingImage, working_image_for
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.border_response_model import (
    BorderResponseModel,
    border_sums,
    response_weights,
)

SIZE = (320, 240)
STRIP = CableState(12.0, 0.2, 24.0, 0.03)
PARAMETERS = preset("thesis")
MODEL = BorderResponseModel(PARAMETERS)


def literal_sums(state, picture, spacing=20.0, sigma=1.6, taps=11) -> np.ndarray:
    """The observation of the thesis: at points along each border a filter across it."""
    height, width = picture.shape
    x = np.arange(taps) - (taps - 1) / 2
    kernel = x / (sigma**3 * np.sqrt(2 * np.pi)) * np.exp(-(x**2) / (2 * sigma**2))
    sums = np.zeros(2)
    for border, side in enumerate((-1.0, 1.0)):
        angle = state[1] + side * state[3]
        cos, sin = np.cos(angle), np.sin(angle)
        offset = (state[0] + side * state[2] / 2) * np.cos(state[3])
        for step in np.arange(-20, 21) * spacing:
            middle = np.array([offset * cos - step * sin, offset * sin + step * cos])
            if abs(middle[0]) > (width - 1) / 2 or abs(middle[1]) > (height - 1) / 2:
                continue
            for place, tap in zip(x, kernel, strict=True):
                column = round((width - 1) / 2 + middle[0] + place * cos)
                row = round((height - 1) / 2 - middle[1] - place * sin)
                inside = picture[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
                sums[border] += tap * inside
    return sums


def working_image(picture, **replaced) -> WorkingImage:
    return working_image_for(picture, PARAMETERS.replaced(replaced))


@pytest.mark.parametrize("angle", [0.0, 0.2, -0.6, 1.3, np.pi / 2])
def test_sums_are_those_of_the_filter_of_the_thesis(draw_strip, angle):
    state = CableState(12.0, angle, 40.0, 0.02)
    picture = draw_strip(state, SIZE, blur=2.0).astype(np.float32)
    image = working_image(picture, sample_spacing=20.0)
    (found,), (lengths,) = border_sums(state.to_array()[None], image)
    expected = literal_sums(state.to_array(), picture)
    # Neither the places of the points nor the smoothing along the border are the same.
    np.testing.assert_allclose(found, expected, rtol=0.25)
    assert (lengths >= 12.0).all()


def test_a_strip_weighs_the_sum_of_both_and_a_step_nothing():
    sums = np.array([[5.0, -7.0], [-5.0, 7.0], [5.0, 7.0], [5.0, -1e-6], [0.0, 0.0]])
    assert response_weights(sums, 1e-3).tolist() == [12.0, 12.0, 1e-3, 1e-3, 1e-3]


def test_evidence_does_not_depend_on_the_size_of_the_frame(draw_strip, rng):
    picture = draw_strip(STRIP, SIZE) + rng.normal(0.0, 8.0, SIZE[::-1])
    large = picture.astype(np.float32)
    small = cv2.resize(large, (160, 120), interpolation=cv2.INTER_AREA)
    half = CableState(STRIP.distance / 2, STRIP.angle, STRIP.width / 2, STRIP.skew)
    of_small, of_large = (
        MODEL.evidence(state.to_array(), working_image(image))
        for state, image in ((half, small), (STRIP, large))
    )
    assert of_small == pytest.approx(of_large, rel=0.25)


def test_the_true_cable_has_more_evidence_than_another_and_one_outside_none(draw_strip):
    image = working_image(draw_strip(STRIP, SIZE), sample_spacing=20.0)
    true, beside, outside = (
        MODEL.evidence(STRIP.to_array() + np.array([shift, *[0.0] * 7]), image)
        for shift in (0.0, 30.0, 500.0)
    )
    assert true > 3.0 * max(beside, 0.1)
    assert outside == 0.0


@given(st.integers(0, 2**32 - 1))
def test_how_a_cable_is_written_makes_no_difference(seed):
    rng = np.random.default_rng(seed)
    image = working_image(rng.normal(100, 20, SIZE[::-1]).astype(np.float32))
    one = rng.uniform([-90, -1.5, 8, -0.2, 0, 0, 0, 0], [90, 1.5, 90, 0.2, 1, 1, 1, 1])
    other = one * np.array([-1, 1, 1, -1, -1, 1, 1, -1]) + np.pi * np.eye(8)[1]
    both = MODEL.log_likelihoods(np.array([one, other]), image)
    assert both[0] == pytest.approx(both[1], abs=1e-3)
