from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.cable.measure.borders.appearance import (
    BESIDE,
    BORDER_REACH,
    DOMINANCE_INSIDE,
    DOMINANCE_OUTSIDE,
    ENOUGH_IN_VIEW,
    FAINTEST,
    IN_VIEW,
    NARROW_DOMINANCE,
    NARROWEST,
    REACH,
    UNDECIDED,
    appearances_of,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.map.cable_map import NO_MAP, CableMap, cable_map_of
from cable_tracker.cable.measure.map.map_strips import strip_shares
from cable_tracker.cable.measure.scanned_gradients import directional_gain
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

SIZE = (320, 240)
MODEL = BorderLikelihoodRatio(TrackerParameters())
STRIP = CableState(20.0, 0.3, 60.0, 0.05)


def appearance(picture, state=STRIP, cable_map=NO_MAP, model=MODEL) -> float:
    image = plain_image(picture.astype(np.float32), SIZE[0])
    strips, scan, ratios = state.to_array()[None], image.scan, model.model_for(image)
    return float(appearances_of(strips, scan, ratios, cable_map)[0])


@pytest.fixture
def inside(draw_strip):
    """Where a strip is, from 0 to 1, shape (h, w)."""

    def inside_of(state):
        return draw_strip(state, SIZE, strip=255.0, ground=0.0).astype(np.float32) / 255.0

    return inside_of


def literal_appearance(picture, column, width) -> float:
    """The appearance of a bright upright strip from a column on, written down step by step."""
    image = plain_image(picture.astype(np.float32), SIZE[0])
    scan = image.scan
    gain = directional_gain(scan.shape, 1.0, 0.0)
    total = UNDECIDED + IN_VIEW * ENOUGH_IN_VIEW
    for edge, inward in ((column, 1), (column + width, -1)):
        means = {}
        for depth in range(-REACH, REACH + 1):
            # Borders lie between two pixels; the one to the right is nearest.
            pixel = edge + inward * depth
            if 0 <= pixel < SIZE[0]:
                means[depth] = inward * gain * scan.rows.gradients[:, pixel, 0].mean()
        border = max(0.0, *(mean for depth, mean in means.items() if abs(depth) <= BORDER_REACH))
        outside = max(abs(mean) for depth, mean in means.items() if depth <= -BESIDE)
        within = [abs(mean) for depth, mean in means.items() if BESIDE <= depth <= width / 2]
        total += DOMINANCE_OUTSIDE * math.log((border + FAINTEST) / (outside + FAINTEST))
        if width / 2 < NARROWEST:
            total += DOMINANCE_INSIDE * NARROW_DOMINANCE
        else:
            total += DOMINANCE_INSIDE * math.log((border + FAINTEST) / (max(within) + FAINTEST))
    return total


@pytest.mark.parametrize("width", [10, 16, 40, 90])
def test_dominances_are_those_of_the_mean_profile(width, rng):
    picture = rng.normal(100.0, 8.0, (240, 320))
    picture[:, 120 : 120 + width] += 20.0
    state = CableState(120 + width / 2 - 160.0, 0.0, float(width), 0.0)
    expected = literal_appearance(picture, 120, width)
    assert appearance(picture, state) == pytest.approx(expected, abs=0.05)


def test_a_faint_cable_looks_more_like_one_than_a_strong_ripple_of_many(bottom, inside):
    cable = inside(STRIP)
    ripples = 30.0 * np.sign(np.sin(2.0 * np.pi * np.arange(240)[:, None] / 24.0))
    picture = (bottom + ripples) * (1.0 - cable) + (0.2 * bottom + 86.0) * cable
    ripple = CableState(6.0, np.pi / 2, 12.0)
    image = plain_image(picture.astype(np.float32), SIZE[0])
    states = np.array([STRIP.to_array(), ripple.to_array()])
    assert np.diff(MODEL.log_likelihoods(states, image))[0] > 0.0
    assert appearance(picture) > appearance(picture, ripple) + 0.4


@pytest.mark.parametrize(("shift", "widening"), [(30.0, 60.0), (-15.0, -30.0), (-60.0, 0.0)])
def test_a_strip_that_shares_one_border_with_the_cable_looks_less_like_one(
    shift, widening, bottom, inside
):
    cable = inside(STRIP)
    picture = bottom * (1.0 - cable) + (0.2 * bottom + 100.0) * cable
    other = CableState(STRIP.distance + shift, STRIP.angle, STRIP.width + widening, STRIP.skew)
    assert appearance(picture) > appearance(picture, other) + 2.0


def test_a_beam_that_ends_in_the_picture_is_no_cable(rng):
    cable = rng.normal(100.0, 5.0, (240, 320))
    cable[:, 150:168] += 60.0
    beam = rng.normal(100.0, 5.0, (240, 320))
    beam[90:210, 150:168] += 60.0
    state = CableState(-0.5, 0.0, 18.0)
    assert appearance(cable, state) > 1.0
    assert appearance(beam, state) < 0.0


def test_the_appearance_of_one_border_in_a_corner_is_undecided(bottom):
    corner = CableState(150.0, 0.6, 120.0, 0.0)
    assert appearance(bottom, corner) < UNDECIDED + 0.4 * IN_VIEW


@pytest.mark.parametrize("factor", [1, 2])
def test_larger_pictures_look_the_same(factor, bottom, inside):
    cable = inside(STRIP)
    picture = bottom * (1.0 - cable) + (0.2 * bottom + 100.0) * cable
    large = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_LINEAR)
    state = CableState(factor * STRIP.distance, STRIP.angle, factor * STRIP.width, STRIP.skew)
    assert appearance(large, state) == pytest.approx(appearance(picture), abs=1.0)


def test_a_picture_without_anything_is_finite():
    assert math.isfinite(appearance(np.full((240, 320), 90.0)))
    assert math.isfinite(appearance(np.full((3, 5), 90.0), CableState(0.0, 0.0, 2.0)))


def map_of(state, probability) -> CableMap:
    """A map that shows a strip, and nothing else."""
    empty = cable_map_of(np.zeros((60, 80), np.float32), -158.0, 118.0, 4.0)
    shown = np.float32(probability) * strip_shares(state.to_array(), empty)
    return cable_map_of(shown, empty.left, empty.top, empty.cell)


def test_the_map_raises_the_appearance_of_its_strip_and_lowers_that_of_others(rng):
    picture = rng.normal(100.0, 10.0, (240, 320))
    elsewhere = CableState(-90.0, -0.3, 40.0)
    shown = appearance(picture, cable_map=map_of(STRIP, 0.9))
    assert shown > appearance(picture) + 2.0
    assert appearance(picture, cable_map=map_of(elsewhere, 0.9)) < appearance(picture) - 2.0
    assert appearance(picture, cable_map=map_of(STRIP, 0.3)) < shown


def test_half_of_what_the_map_shows_looks_less_like_a_cable(rng):
    picture, half = rng.normal(100.0, 10.0, (240, 320)), replace(STRIP, width=30.0)
    cable_map = map_of(STRIP, 0.9)
    gained = [
        appearance(picture, state, cable_map) - appearance(picture, state)
        for state in (STRIP, half)
    ]
    assert gained[1] < gained[0]


@pytest.mark.parametrize("first", [0, 75])
def test_a_cable_with_a_covered_end_looks_like_one_by_the_rest(first, rng):
    picture = rng.normal(100.0, 5.0, (240, 320))
    picture[first : first + 165, 150:168] += 60.0
    state = CableState(-0.5, 0.0, 18.0)
    never = BorderLikelihoodRatio(TrackerParameters(covered_cost=1000.0))
    cable_map = map_of(state, 0.5)
    assert (
        appearance(picture, state, cable_map) > appearance(picture, state, cable_map, never) + 2.0
    )
    assert appearance(picture, state) == appearance(picture, state, model=never)


def test_a_cable_with_bands_looks_like_a_cable(inside, noise_picture):
    # Each band is as long as two stretches; the bottom is as bright as their mean.
    bands = np.where(np.arange(SIZE[1]) // 60 % 2 == 0, 60.0, -60.0)[:, None]
    bottom = noise_picture(3, SIZE, 12.0).astype(np.float32)
    shape = inside(STRIP)
    picture = bottom * (1 - shape) + shape * (128.0 + bands)
    never = BorderLikelihoodRatio(TrackerParameters(reversal_cost=1000.0))
    assert appearance(picture) > max(appearance(picture, model=never), 0.0) + 5.0
