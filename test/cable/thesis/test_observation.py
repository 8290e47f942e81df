from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.geometry import CABLES_AT_ONCE, project_borders
from cable_tracker.cable.model.initialisation import random_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.observation import (
    BorderObservation,
    derivative_of_gaussian,
    interpolate,
)

TRUE = CableState(15.0, 0.2, 50.0, 0.05)
LOG_EPSILON = math.log(1e-3)


def weights_of(image, *states, parameters=None) -> np.ndarray:
    model = BorderObservation(parameters or TrackerParameters())
    working = make_working_image(image, 320)
    return np.exp(model.log_likelihoods(np.array([s.to_array() for s in states]), working))


def literal_filter(x: float, sigma: float = 1.6) -> float:
    return -x / (sigma**3 * math.sqrt(2 * math.pi)) * math.exp(-(x**2) / (2 * sigma**2))


def literal_grey(image, x: float, y: float) -> float:
    """Grey level at a place of the image frame, bilinear, the outermost pixels going on."""
    height, width = image.shape
    column, row = (width - 1) / 2 + x, (height - 1) / 2 - y
    left, top = math.floor(column), math.floor(row)
    value = 0.0
    for i in (left, left + 1):
        for j in (top, top + 1):
            share = (1 - abs(column - i)) * (1 - abs(row - j))
            value += share * float(image[min(max(j, 0), height - 1), min(max(i, 0), width - 1)])
    return value


def literal_score(image, angle: float, rho: float, spacing: float) -> float:
    """The sum of a border's responses as section 4.4 of the thesis describes it."""
    height, width = image.shape
    normal = (math.cos(angle), math.sin(angle))
    score = 0.0
    for k in range(-200, 201):
        x = rho * normal[0] - k * spacing * normal[1]
        y = rho * normal[1] + k * spacing * normal[0]
        if abs(x) > (width - 1) / 2 or abs(y) > (height - 1) / 2:
            continue
        for tap in range(-5, 6):
            grey = literal_grey(image, x + tap * normal[0], y + tap * normal[1])
            score += literal_filter(-tap) * grey
    return score


def literal_weight(image, state: np.ndarray, spacing: float) -> float:
    d, alpha, w, beta = state[:4]
    left = literal_score(image, alpha - beta, (d - w / 2) * math.cos(beta), spacing)
    right = literal_score(image, alpha + beta, (d + w / 2) * math.cos(beta), spacing)
    flat = min(abs(left), abs(right)) < 1e-3
    return abs(left) + abs(right) if left * right < 0 and not flat else 1e-3


def test_weights_are_those_of_the_thesis_done_by_hand(draw_strip, rng):
    parameters = preset("thesis").replaced({"particle_count": 6})
    image = draw_strip(TRUE, blur=3.0)
    states = random_states(parameters, 320, rng)
    states[0] = TRUE.to_array()
    states[1] = CableState(20.0, 0.25, 40.0, 0.0).to_array()
    states[2] = CableState(120.0, -0.5, 90.0, 0.1).to_array()
    states[3] = CableState(-15.0, 0.2 - np.pi, 50.0, -0.05).to_array()
    found = np.exp(
        BorderObservation(parameters).log_likelihoods(states, make_working_image(image, 320))
    )
    expected = [literal_weight(image, state, 20.0) for state in states]
    assert max(expected) > 100
    # OpenCV 4 interpolates in steps of 1/32 px.
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=0.05)


def test_the_filter_is_the_derivative_of_a_gaussian():
    kernel = derivative_of_gaussian(11, 1.6)
    np.testing.assert_allclose(kernel, [literal_filter(-x) for x in range(-5, 6)])
    assert kernel.sum() == pytest.approx(0.0, abs=1e-15)
    # Across a ramp it measures the slope.
    assert kernel @ (3.0 * np.arange(-5, 6)) == pytest.approx(3.0, rel=0.02)


def test_interpolation_reads_between_pixels_and_goes_on_beyond_the_edge():
    pixels = np.array([[0.0, 10.0], [20.0, 30.0]], dtype=np.float32)
    positions = np.array([[0.0, 0.0], [0.5, 0.5], [1.0, 0.25], [-3.0, 0.0], [9.0, 9.0]])
    np.testing.assert_allclose(interpolate(pixels, *positions.T), [0.0, 15.0, 15.0, 0.0, 30.0])


@pytest.mark.parametrize(
    "wrong",
    [
        CableState(20.0, 0.2, 50.0, 0.05),
        CableState(10.0, 0.2, 50.0, 0.05),
        CableState(15.0, 0.25, 50.0, 0.05),
        CableState(15.0, 0.2, 56.0, 0.05),
        CableState(15.0, 0.2, 44.0, 0.05),
        CableState(15.0, 0.2, 50.0, 0.1),
        CableState(15.0, 0.2, 50.0, 0.0),
        CableState(-60.0, 0.2, 50.0, 0.05),
    ],
)
def test_the_true_cable_weighs_more_than_a_shifted_one(draw_strip, wrong):
    true_weight, wrong_weight = weights_of(draw_strip(TRUE), TRUE, wrong)
    assert true_weight > 1.05 * wrong_weight


def test_both_ways_of_writing_a_cable_weigh_the_same(draw_strip):
    other = CableState(-15.0, 0.2 + np.pi, 50.0, -0.05)
    first, second = weights_of(draw_strip(TRUE), TRUE, other)
    assert second == pytest.approx(first, rel=1e-3)


def test_a_dark_cable_weighs_as_much_as_a_bright_one(draw_strip, rng):
    states = [
        CableState.from_array(s)
        for s in random_states(TrackerParameters(particle_count=100), 320, rng)
    ]
    image = draw_strip(TRUE)
    np.testing.assert_allclose(
        weights_of(image, TRUE, *states), weights_of(255 - image, TRUE, *states), rtol=1e-3
    )


def test_borders_that_both_brighten_the_same_way_weigh_epsilon():
    ramp = np.tile(np.linspace(0, 255, 320, dtype=np.float32), (240, 1))
    weights = weights_of(ramp, CableState(0.0, 0.0, 50.0), CableState(30.0, 0.4, 80.0, 0.1))
    np.testing.assert_allclose(weights, 1e-3)


@pytest.mark.parametrize("value", [0, 127, 255])
def test_a_flat_picture_gives_every_cable_epsilon(value, rng):
    states = random_states(TrackerParameters(particle_count=300), 320, rng)
    model = BorderObservation(TrackerParameters())
    working = make_working_image(np.full((240, 320), value, np.uint8), 320)
    np.testing.assert_allclose(model.log_likelihoods(states, working), LOG_EPSILON)


def test_cables_outside_the_image_weigh_epsilon(draw_strip):
    weights = weights_of(
        draw_strip(TRUE), CableState(1e4, 0.0, 30.0), CableState(-300.0, 1.5, 20.0, 0.01)
    )
    np.testing.assert_allclose(weights, 1e-3)


def test_a_cable_across_the_whole_image_is_seen(draw_strip):
    lying = CableState(10.0, np.pi / 2, 40.0)
    true_weight, wrong_weight = weights_of(
        draw_strip(lying), lying, CableState(10.0, np.pi / 4, 40.0)
    )
    assert true_weight > 3 * wrong_weight


def test_sums_are_signed_and_counts_are_of_points_inside(draw_strip):
    model = BorderObservation(preset("thesis"))
    states = np.array([[0.0, 0.0, 50.0, 0.0]])
    working = make_working_image(draw_strip(CableState(0.0, 0.0, 50.0)), 320)
    responses = model.measure(project_borders(states), working)
    assert responses.counts.tolist() == [[11.0, 11.0]]  # y = -100, -80 .. 100.
    assert responses.sums[0, 0] > 0 > responses.sums[0, 1]
    assert responses.opposed().tolist() == [True]


@pytest.mark.parametrize("width", [48, 64, 160, 640, 1280])
def test_a_picture_of_any_size_shows_the_same_cable(draw_strip, width):
    scale = width / 320
    size = (width, width * 3 // 4)
    states = [
        CableState(s.distance * scale, s.angle, s.width * scale, s.skew)
        for s in (TRUE, CableState(25.0, 0.2, 50.0, 0.05), CableState(15.0, 0.2, 70.0, 0.05))
    ]
    weights = weights_of(draw_strip(states[0], size, blur=scale), *states)
    assert weights[0] > 1.2 * weights[1:].max()


@pytest.mark.parametrize("changes", [{"filter_taps": 10}, {"filter_taps": 3}, {"filter_taps": 101}])
def test_filters_of_any_length_see_the_cable(draw_strip, changes):
    parameters = TrackerParameters().replaced(changes)
    true_weight, wrong = weights_of(
        draw_strip(TRUE), TRUE, CableState(30.0, 0.2, 50.0, 0.05), parameters=parameters
    )
    assert true_weight > wrong


def test_many_cables_are_measured_as_few_are(draw_strip, rng):
    count = 2 * CABLES_AT_ONCE + 1
    states = random_states(TrackerParameters(particle_count=count), 320, rng)
    working = make_working_image(draw_strip(TRUE), 320)
    model = BorderObservation(TrackerParameters())
    few = [model.log_likelihoods(states[k : k + 1], working)[0] for k in range(0, count, 97)]
    np.testing.assert_allclose(model.log_likelihoods(states, working)[::97], few, rtol=1e-6)
