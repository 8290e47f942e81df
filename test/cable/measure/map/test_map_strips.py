from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cable_tracker.cable.measure.map.cable_map import (
    AS_THE_STRIP,
    NO_MAP,
    cable_map_of,
    map_overlap,
)
from cable_tracker.cable.measure.map.map_strips import (
    MAP_BLUR,
    MOST_WIDENING,
    map_borders,
    strip_shares,
    strips_of_map,
)
from cable_tracker.cable.model.geometry import relative_direction
from cable_tracker.cable.model.state import CableState
from cable_tracker.particle_filter.existence import probability_of

EMPTY = cable_map_of(np.zeros((60, 80), np.float32), -158.0, 118.0, 4.0)
SMALL = cable_map_of(np.zeros((30, 40), np.float32), -78.0, 58.0, 4.0)
CABLE, OTHER = CableState(-30.0, 0.4, 40.0, 0.05), CableState(60.0, 0.3, 16.0)

EVEN = np.full((240, 320), 100.0, np.float32)


def map_of(*strips, probability=0.9, size=EMPTY):
    shares = sum(strip_shares(strip.to_array(), size) for strip in strips)
    return cable_map_of(np.float32(probability) * shares, size.left, size.top, size.cell)


def pose_near(found, strip) -> np.ndarray:
    """d, alpha, w, beta of a found strip, its normal within pi/2 of that of another one."""
    turn, sign = relative_direction(found[1], strip.angle)
    return np.array([sign * found[0], turn + strip.angle, found[2], sign * found[3]])


@given(
    st.builds(
        CableState,
        st.floats(-30.0, 30.0),
        st.floats(-1.5, 1.5),
        st.floats(12.0, 40.0),
        st.floats(-0.1, 0.1),
    ),
    st.floats(0.2, 1.0),
)
@settings(max_examples=12)
def test_the_only_strip_of_a_map_is_found(strip, probability):
    where = map_of(strip, probability=probability, size=SMALL)
    (found,) = strips_of_map(where, 1)
    # As a share: near 1, where its log-odds are steep, half a pixel is worth more than a nat.
    best = probability_of(map_overlap(strip.to_array(), where))
    assert probability_of(map_overlap(found, where)) > best - 0.05


@pytest.mark.parametrize("strip", [CABLE, OTHER])
def test_its_numbers_are_those_of_the_strip(strip):
    found = pose_near(strips_of_map(map_of(strip), 1)[0], strip)
    assert found == pytest.approx(strip.to_array()[:4], abs=2.0)
    assert found[[1, 3]] == pytest.approx(strip.to_array()[[1, 3]], abs=0.04)


def test_the_larger_strip_of_a_map_comes_first():
    first, second = strips_of_map(map_of(CABLE, OTHER), 2)
    assert pose_near(first, CABLE)[[0, 2]] == pytest.approx([-30.0, 40.0], abs=3.0)
    assert pose_near(second, OTHER)[[0, 2]] == pytest.approx([60.0, 16.0], abs=3.0)


def test_a_map_that_shows_nothing_has_no_strips():
    assert strips_of_map(EMPTY, 2).shape == (0, 8)
    assert strips_of_map(NO_MAP, 2).shape == (0, 8)


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 40))
@settings(max_examples=15)
def test_any_map_has_strips_that_are_numbers(seed, rows, columns):
    probabilities = np.random.default_rng(seed).random((rows, columns)).astype(np.float32)
    assume(probabilities.sum() > 1.0)
    found = strips_of_map(cable_map_of(probabilities, 0.0, 0.0, 4.0), 2)
    assert len(found) >= 1
    assert np.isfinite(found).all()
    assert (found[:, 2] > 0.0).all()


def sure_map_of(strip: CableState, probability: float = 1.0):
    return map_of(strip, probability=probability)


def widening_of(state, cable_map) -> float:
    """How much wider a map shows a strip, on both sides together, as a part of a cable or not."""
    borders = map_borders(state, cable_map, EVEN, 1.0)
    return borders.widening - borders.left_rim - borders.right_rim


@settings(max_examples=25, deadline=None)
@given(
    distance=st.floats(-30.0, 30.0),
    angle=st.floats(-1.5, 1.5),
    width=st.floats(20.0, 60.0),
    wider=st.floats(-5.0, 7.0),
)
def test_a_map_says_no_more_than_it_shows_and_at_most_a_cell_less(distance, angle, width, wider):
    strip = CableState(distance, angle, width)
    shown = sure_map_of(CableState(distance, angle, width + wider))
    expected = wider - MAP_BLUR * EMPTY.cell
    found = widening_of(strip.to_array(), shown)
    assert min(expected, 0.0) - 1.0 <= found <= max(expected, 0.0) + 1.0
    # The steps end where the overlap grows no further, which may be short of the map's borders.
    assert found == pytest.approx(expected, abs=1.2 * EMPTY.cell)


def test_a_map_says_how_much_wider_strips_are_that_lie_anyhow_on_its_cells():
    rng = np.random.default_rng(4)
    expected, errors = np.empty(100), np.empty(100)
    for row in range(100):
        distance, angle = rng.uniform(-30.0, 30.0), rng.uniform(-1.5, 1.5)
        width, wider = rng.uniform(20.0, 60.0), rng.uniform(-5.0, 7.0)
        strip, shown = (CableState(distance, angle, each) for each in (width, width + wider))
        expected[row] = wider - MAP_BLUR * EMPTY.cell
        errors[row] = abs(widening_of(strip.to_array(), sure_map_of(shown)) - expected[row])
    assert (errors <= np.maximum(1.5, 0.5 * np.abs(expected))).all()
    assert np.quantile(errors, 0.8) < 0.5


def test_without_a_map_the_borders_are_those_of_the_strip():
    strip = CableState(0.0, 0.2, 20.0).to_array()
    assert map_borders(strip, NO_MAP, EVEN, 1.0) == AS_THE_STRIP


def test_the_widening_of_a_thin_strip_is_bounded_by_its_width():
    strip, shown = CableState(0.0, 0.2, 8.0), sure_map_of(CableState(0.0, 0.2, 15.0))
    assert widening_of(strip.to_array(), shown) == pytest.approx(MOST_WIDENING * 8.0)


@pytest.mark.parametrize("angle", [0.0, 0.3, -1.2])
@pytest.mark.parametrize("aside", [-8.0, 0.0, 8.0])
def test_a_stripe_of_a_cable_is_widened_to_what_the_map_shows(angle, aside):
    stripe, cable = CableState(10.0 + aside, angle, 12.0), CableState(10.0, angle, 32.0)
    widening, left, right = map_borders(stripe.to_array(), sure_map_of(cable), EVEN, 1.0)
    assert widening == 0.0
    assert -left == pytest.approx(10.0 + aside, abs=3.0)
    assert -right == pytest.approx(10.0 - aside, abs=3.0)


@pytest.mark.parametrize(
    "strip",
    [CableState(0.0, 0.6, 12.0), CableState(40.0, 0.2, 12.0)],
    ids=["across the cable", "beside the cable"],
)
def test_a_strip_that_is_no_part_of_the_cable_has_no_rims(strip):
    shown = sure_map_of(CableState(0.0, 0.2, 32.0))
    assert map_borders(strip.to_array(), shown, EVEN, 1.0)[1:] == (0.0, 0.0)


def test_a_stripe_of_what_a_map_hardly_shows_stays_as_it_is():
    stripe, pale = CableState(0.0, 0.2, 12.0), sure_map_of(CableState(0.0, 0.2, 32.0), 0.5)
    assert map_borders(stripe.to_array(), pale, EVEN, 1.0)[1:] == (0.0, 0.0)


def test_cells_that_are_pale_within_the_cable_make_it_no_narrower():
    strip = CableState(0.0, 0.2, 24.0)
    shown = sure_map_of(strip, probability=0.6)
    assert abs(widening_of(strip.to_array(), shown)) < 2.5


def seen_beside(strip: CableState, cable: CableState, rim: float, reduction: float = 1.0):
    """Return a picture of dark cable on rippled ground; the rest of a strip has a grey level."""
    height, width = round(240 * reduction), round(320 * reduction)
    picture = 100.0 + np.random.default_rng(7).normal(0.0, 8.0, (height, width))
    y, x = np.mgrid[:height, :width]
    x, y = (x - 0.5 * (width - 1)) / reduction, (0.5 * (height - 1) - y) / reduction
    for state, level in ((strip, rim), (cable, 40.0)):
        across = x * math.cos(state.angle) + y * math.sin(state.angle) - state.distance
        picture = np.where(np.abs(across) < 0.5 * state.width, level, picture)
    return picture.astype(np.float32)


@pytest.mark.parametrize("angle", [-1.3, -0.4, 0.2, 1.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("reduction", [1.0, 0.5])
def test_a_dark_part_of_a_strip_that_a_map_leaves_out_is_a_shadow(angle, side, reduction):
    strip, cable = CableState(8.0, angle, 70.0), CableState(8.0 - 10.0 * side, angle, 50.0)
    picture = seen_beside(strip, cable, 40.0, reduction)
    _, left, right = map_borders(strip.to_array(), sure_map_of(cable), picture, reduction)
    shadow, other = (right, left) if side > 0.0 else (left, right)
    assert shadow == pytest.approx(20.0, abs=4.0)
    assert other == 0.0


def test_a_rim_as_light_as_the_ground_is_taken_for_sand_on_the_cable():
    strip, cable = CableState(0.0, 0.2, 70.0), CableState(-10.0, 0.2, 50.0)
    picture = seen_beside(strip, cable, 98.0)
    assert map_borders(strip.to_array(), sure_map_of(cable), picture, 1.0)[1:] == (
        0.0,
        0.0,
    )


def test_a_thin_strip_and_one_that_a_map_hardly_shows_have_no_shadow():
    strip, cable = CableState(0.0, 0.2, 24.0), CableState(-4.0, 0.2, 16.0)
    picture = seen_beside(strip, cable, 40.0)
    assert map_borders(strip.to_array(), sure_map_of(cable), picture, 1.0)[1:] == (
        0.0,
        0.0,
    )
    strip, cable = CableState(0.0, 0.2, 70.0), CableState(-10.0, 0.2, 50.0)
    picture, pale = seen_beside(strip, cable, 40.0), sure_map_of(cable, probability=0.6)
    assert map_borders(strip.to_array(), pale, picture, 1.0)[1:] == (0.0, 0.0)
