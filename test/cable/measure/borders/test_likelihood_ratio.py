from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measured_points import ratios_at
from plain_images import plain_image

from cable_tracker.cable.learning.recorded_points import measure_points
from cable_tracker.cable.measure.borders.likelihood_ratio import (
    EITHER,
    JOINT_STRENGTHS,
    BorderLikelihoodRatio,
    border_clearness,
    bright_share,
    marginal_log_ratios,
    polarity_prior,
)
from cable_tracker.cable.measure.borders.response_table import CLASSES, load_table
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import ParameterError

SIZE = (160, 120)
STRIP = CableState(12.0, 0.2, 24.0, 0.03)
MODEL = BorderLikelihoodRatio(TrackerParameters())

RATIOS, PROBABILITIES = st.floats(-50, 50), st.floats(0.02, 0.98)


def changed(**changes) -> np.ndarray:
    values = STRIP.to_array()
    names = list(CableState.__slots__)
    for name, change in changes.items():
        values[names.index(name)] += change
    return values


def measured(image, *states):
    return MODEL.measure(np.array(states), plain_image(image))


@pytest.fixture
def strip(draw_strip, noise_picture):
    """A bright strip on a bottom with some texture."""
    picture = draw_strip(STRIP, SIZE, strip=180.0, ground=80.0).astype(np.float32)
    return picture + noise_picture(1, SIZE, 6.0).astype(np.float32) - 110.0


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(
    "change",
    [
        {"distance": 4.0},
        {"distance": 30.0},
        {"angle": 0.1},
        {"angle": 0.8},
        {"width": 8.0},
        {"skew": 0.12},
    ],
    ids=str,
)
def test_the_true_cable_is_likelier_than_others(strip, change, sign):
    other = changed(**{name: sign * value for name, value in change.items()})
    true, wrong = marginal_log_ratios(measured(strip, changed(), other).log_ratios, EITHER)
    assert true > wrong + 0.5


def test_the_true_cable_speaks_for_itself_and_a_wrong_one_against(strip):
    found = measured(strip, changed(), changed(distance=-40.0))
    assert found.log_ratios[0, 0] > 1.0
    assert found.border_means[0, 0].min() > 0.5
    assert found.log_ratios[1].max() < 0.0
    assert found.border_means[1].min(axis=1).max() < 0.0


def test_each_border_has_evidence_of_its_own(strip):
    # The right border lies on that of the strip, the left one beside it.
    wide = changed(distance=-10.0, width=20.0)
    found = measured(strip, changed(), wide)
    own, beside = found.border_means[:, 0]
    assert own.min() > 0.5
    assert beside[0] < 0.0
    assert beside[1] > 0.5


@pytest.fixture
def banded(strip):
    """The strip, dark in the lower half of the picture."""
    picture = strip.copy()
    picture[60:] = 2.0 * 80.0 - picture[60:]
    return picture


def test_bands_of_a_cable_cost_less_than_borders_of_the_wrong_polarity(strip, banded):
    never = BorderLikelihoodRatio(TrackerParameters(reversal_cost=1e3, covered_cost=1e3))
    plain = measured(strip, changed()).log_ratios.max()
    with_bands = measured(banded, changed())
    without = never.measure(changed()[None], plain_image(banded)).log_ratios.max()
    assert without < 0.4 * plain
    # Along the cable the picture is 10 stretches long; those with an end of a band say less.
    assert with_bands.log_ratios.max() > plain - 10 * TrackerParameters().reversal_cost
    turned = [int(bands).bit_count() for bands in with_bands.reversed[0]]
    assert 4 <= max(turned) <= 6


def test_bands_shorter_than_a_stretch_are_those_of_a_striped_cable(strip):
    striped = strip.copy()
    for first in range(0, len(strip), 16):
        striped[first : first + 8] = 2.0 * 80.0 - striped[first : first + 8]
    may_be, never = (
        BorderLikelihoodRatio(TrackerParameters(reversal_cost=cost)) for cost in (3.0, 1e3)
    )
    states, image = np.array([changed(), changed(distance=30.0)]), plain_image(striped)
    true, beside = may_be.measure(states, image).log_ratios.max(axis=1)
    assert true > never.measure(states, image).log_ratios.max() + 5.0
    assert beside < 0.0


def test_a_cable_of_one_tone_has_no_reversed_stretch(strip):
    # Nor is it a dark cable that is bright all along.
    assert measured(strip, changed()).reversed.tolist() == [[0, 0]]


def test_a_strip_in_a_corner_is_clear_though_little_of_it_is_shown(draw_strip, noise_picture):
    through, corner = CableState(0.0, 0.7, 16.0, 0.0), CableState(60.0, 0.7, 16.0, 0.0)
    found = []
    for strip in (through, corner):
        picture = draw_strip(strip, SIZE) + noise_picture(1, SIZE, 4.0).astype(np.float32) - 128.0
        scan, model = plain_image(picture).scan, MODEL.model_for(plain_image(picture))
        elsewhere = replace(strip, distance=strip.distance - 40.0)
        states = np.array([strip.to_array(), elsewhere.to_array()])
        found.append(border_clearness(states, scan, model))
    middle, in_corner = found
    # A short border tells less of how strong it is, which costs each of its points more.
    assert 1.0 < in_corner.clearness[0] <= middle.clearness[0]
    assert middle.shown[0] == 1.0
    assert 0.1 < in_corner.shown[0] < 0.6
    assert max(middle.clearness[1], in_corner.clearness[1]) < 0.0


def test_a_cable_out_of_view_shows_nothing(strip):
    scan, model = plain_image(strip).scan, MODEL.model_for(plain_image(strip))
    found = border_clearness(changed(distance=500.0)[None, :], scan, model)
    assert found.shown[0] == 0.0
    assert found.clearness[0] < 0.0


def test_a_negative_of_the_picture_swaps_bright_and_dark(strip):
    states = [changed(distance=d, angle=a) for d in (-20, 0, 3, 30) for a in (-0.3, 0, 0.02)]
    picture, negative = (
        MODEL.measure(np.array(states), plain_image(image)) for image in (strip, 255.0 - strip)
    )
    np.testing.assert_allclose(picture.log_ratios, negative.log_ratios[:, ::-1], atol=0.15)
    np.testing.assert_allclose(picture.border_means, negative.border_means[:, ::-1], atol=0.2)
    assert picture.log_ratios[4, 0] > picture.log_ratios[4, 1]


def test_how_a_cable_is_written_makes_no_difference(strip):
    here = changed(distance=1.0)
    there = here * np.array([-1, 1, 1, -1, -1, 1, 1, -1]) + np.pi * np.eye(8)[1]
    one, other = measured(strip, here, there).log_ratios
    np.testing.assert_allclose(one, other, atol=1e-6)


def test_a_cable_outside_the_image_is_seen_nowhere_and_not_believed(strip):
    found = measured(strip, changed(distance=500.0), changed())
    assert found.visible_lengths[0] == 0.0
    assert found.visible_lengths[1] > 3.0
    assert found.log_ratios[0].max() < 0.0
    assert np.ptp(found.log_ratios[0]) == 0.0


def test_a_cable_half_outside_has_less_to_say_than_one_within(draw_strip):
    inside, edge = (CableState(d, 0.0, 24.0) for d in (0.0, 79.0))
    ratios = [
        measured(draw_strip(state, SIZE), state.to_array()).log_ratios[0, 0]
        for state in (inside, edge)
    ]
    assert ratios[0] > ratios[1] + 0.5


@pytest.mark.parametrize("value", [0, 128, 255])
def test_a_flat_picture_speaks_against_every_cable(value, rng):
    states = rng.uniform(-1, 1, (50, 8)) * np.array([70, 1.5, 0, 0.1, 1, 1, 1, 1])
    states[:, 2] = rng.uniform(5, 60, 50)
    found = measured(np.full(SIZE[::-1], value, np.uint8), *states)
    assert (found.log_ratios < 0.0).all()
    assert (found.border_means.min(axis=2) < 0.0).all()
    # No response at all lies on the border of two bins of the table, which differ a little.
    np.testing.assert_allclose(found.log_ratios[:, 0], found.log_ratios[:, 1], rtol=0.4)


def test_the_scene_twice_as_large_has_nearly_the_same_ratios(draw_strip):
    # Both fill the reference width or less: nothing is reduced.
    double = CableState(24.0, 0.2, 48.0, 0.03)
    small = measured(draw_strip(STRIP, SIZE, blur=2.0), STRIP.to_array(), changed(distance=20.0))
    large = measured(
        draw_strip(double, (320, 240), blur=4.0),
        double.to_array(),
        double.to_array() + np.array([40.0, *[0.0] * 7]),
    )
    assert large.log_ratios[0, 0] == pytest.approx(small.log_ratios[0, 0], rel=0.25)
    for wrong in (small.log_ratios.ravel()[1:], large.log_ratios.ravel()[1:]):
        assert (wrong < 0.0).all()
    np.testing.assert_allclose(large.visible_lengths, small.visible_lengths, atol=1.0)


def test_a_frame_that_is_reduced_has_nearly_the_ratios_of_the_small_one(draw_strip):
    double = CableState(24.0, 0.2, 48.0, 0.03)
    picture = draw_strip(double, (320, 240), blur=3.0)
    whole, reduced = (
        MODEL.measure(double.to_array()[None], plain_image(picture, width)).log_ratios
        for width in (320, 160)
    )
    np.testing.assert_allclose(reduced, whole, rtol=0.35, atol=0.4)


def test_denser_scan_lines_say_about_as_much(strip):
    images = [plain_image(strip, sample_spacing=spacing) for spacing in (16.0, 2.5)]
    assert [image.line_spacing for image in images] == [8, 1]
    sparse, dense = (MODEL.measure(changed()[None], image).log_ratios[0, 0] for image in images)
    assert dense == pytest.approx(sparse, rel=0.25)


@pytest.mark.parametrize(
    ("tempering", "spacing", "power"),
    [(0.1875, 8.0, 0.3), (0.1875, 40.0, 1.0), (1.0, 8.0, 1.0), (0.5, 4.0, 0.4)],
)
def test_points_far_apart_count_as_independent_ones_and_no_more(strip, tempering, spacing, power):
    image = plain_image(strip, sample_spacing=spacing)
    ratio = BorderLikelihoodRatio(TrackerParameters(tempering=tempering))
    assert image.line_spacing / image.scale == pytest.approx(spacing, abs=1.0)
    assert ratio.model_for(image).tempering == pytest.approx(power)


def test_no_cable_at_all_is_measured_as_none(strip):
    found = MODEL.measure(np.empty((0, 8)), plain_image(strip))
    assert found.log_ratios.shape == found.border_means.min(axis=2).shape == (0, 2)
    assert found.visible_lengths.shape == (0,)


def test_in_a_tall_picture_a_cable_across_is_as_clear_as_one_that_runs_down(draw_strip):
    down, across = (
        MODEL.evidence(state.to_array(), plain_image(draw_strip(state, (180, 320))))
        for state in (CableState(5.0, 0.0, 20.0), CableState(5.0, np.pi / 2, 20.0))
    )
    assert across == pytest.approx(down, rel=0.1)


def literal_log_ratios(state, image, table, parameters) -> np.ndarray:
    """The model written down from its definition, over the points that learning records."""
    tempering = parameters.tempering * image.line_spacing / image.scale / 5.0
    expected = min(image.size) / image.line_spacing
    points = measure_points(state[None], image)
    ratios, sums = ratios_at(points.measures, table), np.zeros((2, 2, CLASSES))
    for border, side in enumerate((-1.0, 1.0)):
        normal = state[1] + side * state[3]
        length = 1.0 / max(abs(np.cos(normal)), abs(np.sin(normal)))
        mine = ratios[points.borders == border]
        missing = max(expected - length * len(mine), 0.0)
        sums[border] = length * mine.sum(axis=0).reshape(2, CLASSES)
        sums[border] += missing * parameters.missing_cost * table.absent
    # Over the strengths of the left and the right border: bright cables, then dark ones.
    joint = np.exp(tempering * (sums[0][:, :, None] + sums[1][:, None, :]))
    return np.log((JOINT_STRENGTHS * joint).sum(axis=(1, 2)))


def test_the_borders_of_a_cable_are_about_as_strong_as_each_other():
    assert JOINT_STRENGTHS.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(JOINT_STRENGTHS, JOINT_STRENGTHS.T)
    assert (np.diag(JOINT_STRENGTHS) > 0.2).all()


@given(st.integers(0, 2**32 - 1))
def test_a_cable_has_the_sum_of_its_points_ratios(seed):
    rng = np.random.default_rng(seed)
    image = plain_image(rng.normal(100.0, 20.0, SIZE[::-1]).astype(np.float32))
    state = np.zeros(8)
    state[:4] = rng.uniform([-90, -np.pi / 2, 4, -0.3], [90, np.pi / 2, 70, 0.3])
    expected = literal_log_ratios(state, image, load_table(""), TrackerParameters())
    uncovered = BorderLikelihoodRatio(TrackerParameters(covered_cost=1e3))
    found = uncovered.measure(state[None], image).log_ratios[0]
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-3)


def test_a_cable_that_goes_under_is_one_as_far_as_it_can_be_seen(strip):
    rng = np.random.default_rng(0)
    half = strip.copy()
    half[60:] = rng.normal(80.0, 6.0, half[60:].shape).clip(0, 255)
    uncovered = BorderLikelihoodRatio(TrackerParameters(covered_cost=1e3))
    states, image = np.array([changed(), changed(distance=40.0)]), plain_image(half)
    true, beside = MODEL.measure(states, image).log_ratios.max(axis=1)
    assert true > uncovered.measure(states, image).log_ratios[0].max() + 3.0
    assert true > 10.0
    assert beside < 0.0


def test_a_missing_table_is_refused_at_once(tmp_path):
    with pytest.raises(ParameterError, match="response_table"):
        BorderLikelihoodRatio(TrackerParameters(response_table=str(tmp_path / "none.json")))


@pytest.mark.parametrize("shape", [(3, 2), (8,)])
def test_cables_of_too_few_columns_are_refused(strip, shape):
    with pytest.raises(ValueError, match="shape"):
        MODEL.measure(np.zeros(shape), plain_image(strip))


@given(RATIOS, RATIOS, PROBABILITIES)
def test_an_unknown_polarity_is_averaged_over(bright, dark, probability):
    polarity = polarity_prior(probability)
    expected = probability * np.exp(bright) + (1 - probability) * np.exp(dark)
    marginal = marginal_log_ratios(np.array([[bright, dark]]), polarity)[0]
    assert marginal == pytest.approx(np.log(expected))
    share = bright_share(polarity, bright, dark)
    assert share == pytest.approx(probability * np.exp(bright) / expected)


def test_shares_of_extreme_ratios_are_no_overflow():
    even = polarity_prior(0.5)
    assert bright_share(even, 1e4, 0.0) == pytest.approx(1.0)
    assert bright_share(even, 0.0, 1e4) == pytest.approx(0.0, abs=1e-12)
