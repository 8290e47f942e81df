from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.cable.measure.map.cable_map import NO_MAP, cable_map_of, strip_shares
from cable_tracker.cable.measure.map.map_width import MAP_BLUR, MOST_WIDENING, map_widening
from cable_tracker.cable.model.state import CableState

EMPTY = cable_map_of(np.zeros((60, 80), np.float32), -158.0, 118.0, 4.0)


def map_of(strip: CableState, probability: float = 1.0):
    shares = np.float32(probability) * strip_shares(strip.to_array(), EMPTY)
    return cable_map_of(shares, EMPTY.left, EMPTY.top, EMPTY.cell)


@settings(max_examples=25, deadline=None)
@given(
    distance=st.floats(-30.0, 30.0),
    angle=st.floats(-1.5, 1.5),
    width=st.floats(20.0, 60.0),
    wider=st.floats(-5.0, 7.0),
)
def test_a_map_says_no_more_than_it_shows_and_at_most_a_cell_less(distance, angle, width, wider):
    strip = CableState(distance, angle, width)
    shown = map_of(CableState(distance, angle, width + wider))
    expected = wider - MAP_BLUR * EMPTY.cell
    found = map_widening(strip.to_array(), shown)
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
        errors[row] = abs(map_widening(strip.to_array(), map_of(shown)) - expected[row])
    assert (errors <= np.maximum(1.5, 0.5 * np.abs(expected))).all()
    assert np.quantile(errors, 0.8) < 0.5


def test_the_widening_is_bounded_by_the_width():
    strip, shown = CableState(0.0, 0.2, 20.0), map_of(CableState(0.0, 0.2, 60.0))
    assert map_widening(strip.to_array(), shown) == pytest.approx(MOST_WIDENING * 20.0)


def test_cells_that_are_pale_within_the_cable_make_it_no_narrower():
    strip = CableState(0.0, 0.2, 24.0)
    shown = map_of(strip, probability=0.6)
    assert abs(map_widening(strip.to_array(), shown)) < 2.5


def test_without_a_map_nothing_is_said():
    assert map_widening(CableState(0.0, 0.2, 24.0).to_array(), NO_MAP) == 0.0
