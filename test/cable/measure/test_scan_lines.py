from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.measure.scan_lines import (
    ScanLineObservation,
    filter_along,
    scan_plan,
    sum_by_table,
)
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.geometry import project_borders
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.observation import BorderObservation

PARAMETERS = preset("thesis")
MODEL = ScanLineObservation(PARAMETERS)
LITERAL = BorderObservation(PARAMETERS)


def measured(model, picture, state):
    borders = project_borders(state.to_array()[None, :])
    return model.measure(borders, make_working_image(picture, 320))


@pytest.mark.parametrize("angle", [-1.5, -0.9, -0.6, 0.0, 0.3, 0.7, 0.85, 1.2, 1.57])
def test_sums_mean_the_same_as_those_of_points_along_the_border(draw_strip, angle):
    state = CableState(5.0, angle, 40.0, 0.05)
    picture = draw_strip(state, (320, 320), blur=1.0)
    found, literal = (measured(model, picture, state) for model in (MODEL, LITERAL))
    # Where the ends of a border lie between two points is worth one of them, more or less.
    np.testing.assert_allclose(found.sums, literal.sums, rtol=0.2)
    np.testing.assert_allclose(found.counts, literal.counts, atol=2.0)
    np.testing.assert_allclose(found.sums / found.counts, literal.sums / literal.counts, rtol=0.12)


@pytest.mark.parametrize("angle", [0.2, 1.3])
def test_the_true_cable_weighs_more_than_a_shifted_one(draw_strip, angle):
    true = CableState(15.0, angle, 50.0, 0.05)
    wrong = [
        CableState(20.0, angle, 50.0, 0.05),
        CableState(15.0, angle + 0.05, 50.0, 0.05),
        CableState(15.0, angle, 56.0, 0.05),
        CableState(15.0, angle, 50.0, 0.0),
    ]
    states = np.array([state.to_array() for state in (true, *wrong)])
    image = make_working_image(draw_strip(true, (320, 320)), 320)
    weights = np.exp(MODEL.log_likelihoods(states, image))
    assert weights[0] > 1.05 * weights[1:].max()


def test_both_ways_of_writing_a_cable_weigh_the_same(draw_strip):
    state = CableState(15.0, 0.2, 50.0, 0.05)
    states = np.array([state.to_array(), CableState(-15.0, 0.2 + np.pi, 50.0, -0.05).to_array()])
    first, second = MODEL.log_likelihoods(states, make_working_image(draw_strip(state), 320))
    assert first == pytest.approx(second, rel=1e-6)


def test_cables_outside_the_image_weigh_epsilon(draw_strip):
    states = np.array([CableState(1e4, 0.0, 30.0).to_array(), CableState(-300, 1.5, 20).to_array()])
    image = make_working_image(draw_strip(CableState(0.0, 0.0, 40.0)), 320)
    np.testing.assert_allclose(MODEL.log_likelihoods(states, image), math.log(1e-3))


@pytest.mark.parametrize("value", [0, 127, 255])
def test_a_flat_picture_answers_nothing(value):
    image = make_working_image(np.full((240, 320), value, np.uint8), 320)
    responses = MODEL.measure(project_borders(np.array([[5.0, 0.3, 40.0, 0.1]])), image)
    assert (responses.sums == 0.0).all()
    assert (MODEL.scattered_responses(image) == 0.0).all()


@pytest.mark.parametrize("size", [(16, 16), (320, 240), (320, 180), (64, 4000), (1000, 30)])
@pytest.mark.parametrize("spacing", [1.0, 20.0, 200.0])
def test_lines_lie_inside_the_picture_and_none_twice(size, spacing):
    plan = scan_plan(size, spacing)
    for lines, length in ((plan.rows, size[1]), (plan.columns, size[0])):
        assert len(set(lines.tolist())) == len(lines) >= 1
        assert 0 <= lines.min() <= lines.max() < length
    assert (plan.grid >= 0).all()
    assert (plan.grid < size[::-1]).all()


def test_the_filter_measures_the_slope_of_a_ramp_and_nothing_beyond_the_edge():
    half = np.array([0.5])
    answers = filter_along(np.arange(6, dtype=np.float32)[None, :] * 3, half)
    np.testing.assert_allclose(answers, [[1.5, 3, 3, 3, 3, 1.5]])


def test_the_scale_of_white_noise_is_that_of_the_filter(noise_picture):
    image = make_working_image(noise_picture(1, (320, 240), 8.0), 320)
    taps = MODEL.half_filter(image)
    assert MODEL.scattered_responses(image).std() == pytest.approx(
        8.0 * math.sqrt(2 * (taps**2).sum()), rel=0.15
    )


def test_sums_of_many_cables_are_looked_up(rng):
    x = np.arange(320)
    positions = np.arange(-100.0, 101.0, 20.0)
    lines = np.exp(-((x - 160 - 0.1 * positions[:, None]) ** 2) / (2 * 2.5**2)).astype(np.float32)
    first, slope = rng.normal(160, 3, 20_000), rng.normal(0.1, 0.01, 20_000)
    found = sum_by_table(lines, positions, 0.5, first, slope)
    alone = [sum_by_table(lines, positions, 0.5, first[k : k + 1], slope[k : k + 1])[0]
             for k in range(0, 20_000, 1000)]  # fmt: skip
    np.testing.assert_allclose(found[::1000], alone, atol=0.03 * 11)
    assert max(alone) > 5.0
