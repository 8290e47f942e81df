from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.picture.bend import (
    STRAIGHT,
    Bend,
    bend_after,
    bend_of_map,
    straightened,
)
from cable_tracker.cable.model.state import CableState

ROWS, COLUMNS = 60, 80


def map_of(draw_strip, bend=STRAIGHT, angle=0.1, width=3.0) -> np.ndarray:
    """Return a map whose cable bends."""
    state = CableState(4.0, angle, width, 0.0)
    strip = draw_strip(state, (COLUMNS, ROWS), strip=250.0, ground=0.0, blur=0.5)
    bent = straightened(strip.astype(np.float32), Bend(-bend.amplitude, bend.is_steep))
    return bent / np.float32(255.0)


@pytest.mark.parametrize("angle", [-1.5, -0.7, 0.0, 0.4, 1.2])
@pytest.mark.parametrize("width", [2.0, 4.0, 20.0])
def test_a_straight_cable_has_no_bend(draw_strip, angle, width):
    assert bend_of_map(map_of(draw_strip, angle=angle, width=width)) == STRAIGHT


@pytest.mark.parametrize("amplitude", [-0.1, -0.05, 0.05, 0.1])
@pytest.mark.parametrize(("is_steep", "angle"), [(True, 0.1), (True, -0.5), (False, 1.4)])
def test_the_bend_of_a_thin_cable_is_found(draw_strip, amplitude, is_steep, angle):
    bend = Bend(amplitude, is_steep)
    found = bend_of_map(map_of(draw_strip, bend, angle))
    assert found.is_steep == is_steep
    # Small bends are taken for smaller ones: a straight cable must not seem to bend.
    assert found.amplitude == pytest.approx(amplitude, rel=0.25)


def test_a_wide_cable_that_bends_less_than_its_width_counts_as_straight(draw_strip):
    assert bend_of_map(map_of(draw_strip, Bend(0.05), width=20.0)) == STRAIGHT


def test_two_cables_have_no_common_bend(draw_strip):
    both = np.maximum(map_of(draw_strip, angle=-0.5), map_of(draw_strip, angle=0.5))
    assert bend_of_map(both) == STRAIGHT


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_a_bend_must_be_marked_along_most_of_the_picture(draw_strip, share):
    bent = map_of(draw_strip, Bend(0.08))
    bent[: round((1.0 - share) * ROWS)] = 0.0
    assert (bend_of_map(bent) != STRAIGHT) == (share > 0.7)


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 40))
def test_any_map_has_a_bend_that_is_a_number(seed, rows, columns):
    probabilities = np.random.default_rng(seed).random((rows, columns)).astype(np.float32)
    assert math.isfinite(bend_of_map(probabilities).amplitude)


@pytest.mark.parametrize(("is_steep", "angle"), [(True, 0.2), (False, 1.4)])
def test_a_straightened_picture_shows_a_straight_cable(draw_strip, is_steep, angle):
    strip = draw_strip(CableState(12.0, angle, 8.0, 0.0))
    bent = straightened(strip, Bend(-0.08, is_steep))
    straight = straightened(bent, Bend(0.08, is_steep))
    assert straight.dtype == np.uint8
    assert np.abs(straight.astype(float) - strip)[20:-20, 20:-20].mean() < 1.0
    assert np.abs(bent.astype(float) - strip)[20:-20, 20:-20].mean() > 5.0


def test_a_picture_without_a_bend_is_returned_itself(draw_strip):
    strip = draw_strip(CableState(0.0, 0.1, 20.0, 0.0))
    np.testing.assert_array_equal(straightened(strip, STRAIGHT), strip)


def test_a_bend_leaves_the_line_of_least_squares_where_it_is():
    displacements = Bend(0.1).displacements(240, 320.0)
    # At the ends it lies a tenth of 320 px to the right, in the middle half of that to the left.
    assert displacements[[0, 120]] == pytest.approx([32.0, -16.0], rel=0.02)
    assert np.abs(np.polyfit(np.arange(240), displacements, 1)).max() < 0.01


def test_a_bend_that_goes_on_is_averaged_and_a_new_one_counts_at_once():
    assert bend_after(STRAIGHT, Bend(0.1)) == Bend(0.1)
    assert bend_after(Bend(0.1), Bend(0.2)) == Bend(0.15000000000000002)
    assert bend_after(Bend(0.1), STRAIGHT) == Bend(0.05)
    assert bend_after(Bend(0.1), Bend(0.2, is_steep=False)) == Bend(0.2, is_steep=False)


@pytest.mark.parametrize("is_steep", [True, False])
def test_a_bend_that_is_no_longer_found_fades_and_ends(is_steep):
    bends = [Bend(0.1, is_steep)]
    while bends[-1] != STRAIGHT:
        bends.append(bend_after(bends[-1], STRAIGHT))
    assert bends[1] == Bend(0.05, is_steep)
    assert len(bends) < 10
