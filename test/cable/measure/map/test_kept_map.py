from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.map.cable_map import (
    NO_MAP,
    cable_map_of,
    map_overlap,
    strip_shares,
)
from cable_tracker.cable.measure.map.kept_map import LONGEST_KEPT, NO_KEPT_MAP, KeptMap
from cable_tracker.cable.measure.map.map_borders import AS_THE_STRIP, MapBorders
from cable_tracker.cable.model.state import CableState

LEFT, TOP, CELL = -158.0, 118.0, 4.0
EMPTY = cable_map_of(np.zeros((60, 80), np.float32), LEFT, TOP, CELL)


def kept_map_of(state: CableState) -> KeptMap:
    """The map of a frame that shows a strip and nothing else."""
    shares = strip_shares(state.to_array(), EMPTY)
    return KeptMap(cable_map_of(shares, LEFT, TOP, CELL), state.to_array()[:4], AS_THE_STRIP)


def overlap(state: CableState, cable_map) -> float:
    return map_overlap(state.to_array(), cable_map)


STRIPS = st.builds(
    CableState,
    st.floats(-60.0, 60.0),
    st.floats(-math.pi / 2 + 1e-3, math.pi / 2),
    st.floats(20.0, 60.0),
    st.floats(-0.1, 0.1),
)


@given(STRIPS, st.floats(-15.0, 15.0), st.floats(-0.15, 0.15), st.booleans())
def test_a_kept_map_shows_the_cable_where_it_has_come_to_in_any_chart(before, shift, turn, turned):
    after = CableState(
        before.distance + shift, before.angle + turn, before.width, before.skew
    ).to_array()
    pose = after[:4].copy()
    if turned:
        pose[[0, 3]] *= -1.0
        pose[1] += math.pi
    moved = kept_map_of(before).moved_to(pose)
    # Between cells it is interpolated: five cells across are not quite as sharp any more.
    assert map_overlap(after, moved) > 1.5


def test_a_strip_that_would_fit_the_old_place_does_not_fit_the_new_one():
    before, after = CableState(0.0, 0.1, 24.0, 0.0), CableState(20.0, 0.3, 24.0, 0.0)
    moved = kept_map_of(before).moved_to(after.to_array())
    assert overlap(after, moved) > 2.0
    assert overlap(before, moved) < 0.0


def test_a_cable_that_has_not_moved_leaves_the_map_as_it_was():
    state = CableState(13.0, -0.4, 30.0, 0.05)
    kept = kept_map_of(state)
    moved = kept.moved_to(state.to_array())
    np.testing.assert_allclose(moved.probabilities, kept.cable_map.probabilities, atol=1e-6)
    assert (moved.left, moved.top, moved.cell) == (LEFT, TOP, CELL)


def test_what_comes_into_view_is_as_the_outermost_cells_are():
    """Else a cable that moves inwards would end before the edge."""
    along_the_edge = CableState(150.0, 0.0, 40.0, 0.0)
    moved = kept_map_of(along_the_edge).moved_to(CableState(110.0, 0.0, 40.0, 0.0).to_array())
    assert moved.probabilities[:, -1].min() == 1.0


def test_an_old_map_says_nothing():
    """Else one would go on for as long as the network is not to look, an hour for instance."""
    state = CableState(0.0, 0.0, 24.0, 0.0)
    kept = kept_map_of(state)
    young, old = (replace(kept, seconds=LONGEST_KEPT - less) for less in (0.01, 0.0))
    assert overlap(state, young.moved_to(state.to_array())) > 2.0
    assert old.moved_to(state.to_array()) is NO_MAP


@pytest.mark.parametrize(("seconds", "least", "most"), [(0.04, 0.5, 1.0), (1.0, 8.0, 9.0)])
def test_what_a_new_map_says_of_the_borders_counts_the_more_the_older_the_kept_one_is(
    seconds, least, most
):
    kept = replace(kept_map_of(CableState(0.0, 0.0, 24.0, 0.0)), seconds=seconds)
    found = kept.smoothed(MapBorders(10.0, 0.0, 6.0))
    assert least < found.widening < most
    assert found.right_rim == pytest.approx(0.6 * found.widening)


def test_without_a_kept_map_a_new_one_alone_says_where_the_borders_are():
    assert NO_KEPT_MAP.moved_to(CableState(0.0, 0.0, 24.0, 0.0).to_array()) is NO_MAP
    assert NO_KEPT_MAP.smoothed(MapBorders(10.0, 0.0, 6.0)) == (10.0, 0.0, 6.0)
