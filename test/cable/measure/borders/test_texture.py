from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.borders.texture import (
    MOST_FOR_ALONG,
    STEP_SLOPE,
    may_speak,
    smoothness,
    texture_log_ratio,
)
from cable_tracker.cable.measure.picture.working_image import make_working_image
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

SIZE = (320, 240)
STRIP = CableState(20.0, 0.3, 60.0, 0.05)
LIMIT = TrackerParameters().texture_limit
STEPS = st.floats(-3.0, 3.0)


def texture_evidence(image, state=STRIP):
    """What texture adds to the log-likelihood ratio of a strip."""
    states, picture = state.to_array()[None], make_working_image(image, SIZE[0])
    with_texture, without = (
        BorderLikelihoodRatio(TrackerParameters(texture_limit=limit)).log_likelihoods(
            states, picture
        )[0]
        for limit in (LIMIT, 0.0)
    )
    return with_texture - without


@pytest.fixture
def inside(draw_strip):
    """Where the strip is, from 0 to 1, shape (h, w)."""
    return draw_strip(STRIP, SIZE, strip=255.0, ground=0.0).astype(np.float32) / 255.0


def test_a_smooth_strip_on_a_rough_bottom_of_its_brightness_is_found_by_its_texture(bottom, inside):
    smooth = 100.0 + 0.1 * (bottom - 100.0)
    assert texture_evidence(inside * smooth + (1.0 - inside) * bottom) > 0.5 * LIMIT


def test_a_shadow_on_the_bottom_has_no_texture_of_its_own(bottom, inside):
    assert texture_evidence(bottom * (1.0 - 0.5 * inside)) == pytest.approx(0.0, abs=1e-9)


def test_a_band_of_sunlight_has_no_texture_of_its_own(bottom, inside):
    assert texture_evidence(bottom * (1.0 + 0.5 * inside)) == pytest.approx(0.0, abs=1e-9)


def test_a_strip_that_is_rougher_than_the_bottom_says_nothing(bottom, inside):
    smooth = 100.0 + 0.1 * (bottom - 100.0)
    rough_strip = inside * bottom + (1.0 - inside) * smooth
    assert texture_evidence(rough_strip) == pytest.approx(0.0, abs=1e-9)


def test_a_strip_beside_the_smooth_one_shares_one_border_with_it_and_gains_nothing(bottom, inside):
    smooth = 100.0 + 0.1 * (bottom - 100.0)
    image = inside * smooth + (1.0 - inside) * bottom
    beside = CableState(STRIP.distance + STRIP.width, STRIP.angle, STRIP.width, STRIP.skew)
    assert texture_evidence(image, beside) == pytest.approx(0.0, abs=1e-9)


def test_what_texture_says_counts_for_either_border_in_the_evidence(bottom, inside):
    smooth = 100.0 + 0.1 * (bottom - 100.0)
    picture = make_working_image(inside * smooth + (1.0 - inside) * bottom, SIZE[0])
    with_texture, without = (
        BorderLikelihoodRatio(TrackerParameters(texture_limit=limit)) for limit in (LIMIT, 0.0)
    )
    more = np.subtract(
        *(
            each.measure(STRIP.to_array()[None], picture).log_ratios
            for each in (with_texture, without)
        )
    )
    gained, plain = (each.evidence(STRIP.to_array(), picture) for each in (with_texture, without))
    # The shorter border is as long as the picture is high, and a little longer for its slope.
    points = picture.size[1] / picture.line_spacing
    tempering = with_texture.model_for(picture).tempering
    assert gained - plain == pytest.approx(more[0, 0] / (tempering * points), rel=0.15)


def test_the_bright_half_of_a_round_cable_is_not_smooth_for_the_shade_beside_it(bottom, inside):
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    across = (columns - SIZE[0] / 2 + 0.5) * np.cos(STRIP.angle) - (
        rows - SIZE[1] / 2 + 0.5
    ) * np.sin(STRIP.angle)
    shade = np.clip((across - STRIP.distance + STRIP.width / 2) / (STRIP.width / 2), 0.0, 1.0)
    skin = 80.0 + 140.0 * shade + 0.2 * (bottom - 100.0)
    image = inside * skin + (1.0 - inside) * bottom
    quarter = STRIP.width / 4
    bright_half = CableState(STRIP.distance + quarter, STRIP.angle, 2 * quarter, 0.0)
    assert texture_evidence(image, bright_half) == pytest.approx(0.0, abs=1e-9)


def test_thin_strips_have_no_inside_to_look_at(bottom, draw_strip):
    thin = CableState(20.0, 0.3, 9.0, 0.0)
    inside = draw_strip(thin, SIZE, strip=255.0, ground=0.0).astype(np.float32) / 255.0
    image = inside * 100.0 + (1.0 - inside) * bottom
    assert texture_evidence(image, thin) == pytest.approx(0.0, abs=1e-9)


@given(STEPS, STEPS, st.floats(0.0, 100.0))
def test_texture_speaks_for_cables_alone_and_within_its_limit(left, right, limit):
    ratio = texture_log_ratio(left, right, limit)
    assert 0.0 <= ratio <= limit
    assert ratio == texture_log_ratio(right, left, limit)
    if min(left, right) <= 0.0:
        assert ratio == 0.0


@given(st.floats(0.0, 3.0), st.floats(0.0, 3.0), st.floats(0.0, 1.0))
def test_a_smoother_side_never_says_less(left, right, more):
    before = texture_log_ratio(left, right, 1e3)
    assert texture_log_ratio(left + more, right, 1e3) >= before - 1e-9
    assert texture_log_ratio(left, right, 1e3) <= STEP_SLOPE * max(left, right)


def sides(inside, outside, inside_pixels=100, outside_pixels=100):
    """What is added up on both sides, of gradients per pixel: along u, mixed, along v."""
    sums = [np.multiply(inside, inside_pixels), np.multiply(outside, outside_pixels)]
    return np.column_stack((sums, [inside_pixels, outside_pixels]))


def isotropic(level):
    return level * np.array([0.5, 0.0, 0.5])


@given(
    st.floats(1e-3, 1.0),
    st.floats(1e-3, 1.0),
    st.integers(12, 400),
    st.integers(12, 400),
    st.floats(-1.0, 1.0),
)
def test_sides_differ_by_their_log_ratio_less_an_error_that_falls_with_the_pixels(
    inside_level, outside_level, inside_pixels, outside_pixels, step
):
    def found(factor):
        levels = isotropic(inside_level), isotropic(outside_level)
        return smoothness(sides(*levels, factor * inside_pixels, factor * outside_pixels), step)

    ratio = np.log(outside_level / inside_level)
    assert found(1) < found(4) < ratio
    assert ratio - found(4) == pytest.approx((ratio - found(1)) / 2)


@given(st.floats(-1.0, 1.0), st.floats(0.1, 1.0))
def test_a_slope_across_the_border_is_no_rough_bottom(step, slope):
    across = np.array([1.0, -step]) / np.hypot(1.0, step)
    limb = slope * np.array([across[0] ** 2, across[0] * across[1], across[1] ** 2])
    skin = isotropic(0.01)
    plain = smoothness(sides(skin, skin), step)
    assert smoothness(sides(skin, skin + limb), step) <= plain + np.log(0.5 * MOST_FOR_ALONG) + 1e-9
    # Turned by a right angle, it is.
    turned = limb[[2, 1, 0]] * [1.0, -1.0, 1.0]
    assert smoothness(sides(skin, skin + turned), step) > 1.0


def test_of_too_few_pixels_nothing_is_said():
    assert smoothness(sides(isotropic(0.01), isotropic(1.0), 11, 100), 0.0) == 0.0
    assert smoothness(sides(isotropic(0.01), isotropic(1.0), 12, 100), 0.0) > 1.0


@given(left=STEPS, right=STEPS)
def test_one_border_that_is_hardly_smoother_is_enough_for_texture_to_say_nothing(left, right):
    if not may_speak(left):
        assert texture_log_ratio(left, right, LIMIT) == 0.0
