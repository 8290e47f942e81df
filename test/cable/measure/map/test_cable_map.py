from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cable_tracker.cable.measure.map.cable_map import (
    AS_THE_STRIP,
    LONGEST_KEPT,
    NO_KEPT_MAP,
    NO_MAP,
    NOTHING_EXPECTED,
    SLACK,
    CableMap,
    ExpectedOverlap,
    KeptMap,
    MapBorders,
    MapWeights,
    bounded_log_odds,
    cable_map_of,
    map_log_ratio,
    map_match,
    map_overlap,
    overlap_of_best,
    overlap_of_expected,
)
from cable_tracker.cable.measure.map.map_strips import strip_shares
from cable_tracker.cable.model.geometry import project_borders
from cable_tracker.cable.model.state import CableState

ROWS, COLUMNS, CELL = 30, 40, 4.0
LEFT, TOP = -158.0, 118.0
LARGE = cable_map_of(np.zeros((60, 80), np.float32), LEFT, TOP, CELL)
WEIGHTS = MapWeights(overlap=3.0, lacking=2.0)
ON_IT, BESIDE = (CableState(distance, 0.0, 24.0, 0.0).to_array() for distance in (0.0, 60.0))


def map_of(probabilities) -> CableMap:
    probabilities = np.asarray(probabilities, np.float32)
    rows, columns = probabilities.shape
    return cable_map_of(
        probabilities,
        -0.5 * CELL * (columns - 1),
        0.5 * CELL * (rows - 1),
        CELL,
    )


EMPTY = map_of(np.zeros((ROWS, COLUMNS)))


def counted_shares(state: CableState, fine: int = 9) -> np.ndarray:
    """The share of each cell between the borders, of `fine` x `fine` points in each."""
    borders = project_borders(state.to_array()[None])
    (left, right), (begin, end) = borders.angles[0], borders.offsets[0]
    steps = (np.arange(fine) + 0.5) / fine - 0.5
    x = EMPTY.left + CELL * (np.arange(COLUMNS)[:, None] + steps).ravel()
    y = EMPTY.top - CELL * (np.arange(ROWS)[:, None] + steps).ravel()
    x, y = np.meshgrid(x, y)
    after = x * np.cos(left) + y * np.sin(left) > begin
    before = x * np.cos(right) + y * np.sin(right) < end
    return (after & before).reshape(ROWS, fine, COLUMNS, fine).mean((1, 3))


STATES = st.builds(
    CableState,
    st.floats(-50.0, 50.0),
    st.floats(-1.5, 1.5),
    st.floats(6.0, 60.0),
    st.floats(-0.15, 0.15),
)


@given(STATES)
def test_shares_are_those_that_points_count(state):
    shares = strip_shares(state.to_array(), EMPTY)
    assert shares == pytest.approx(counted_shares(state), abs=0.35)
    assert shares.sum() == pytest.approx(counted_shares(state).sum(), rel=0.02, abs=4.0)


@given(STATES)
def test_the_strip_that_a_map_shows_matches_it_best(state):
    shares = strip_shares(state.to_array(), EMPTY)
    assume(shares.sum() >= 20.0)
    best = map_overlap(state.to_array(), map_of(shares))
    for change in ((10.0, 0.0, 0.0), (-10.0, 0.0, 0.0), (0.0, 0.0, 12.0), (0.0, 0.5, 0.0)):
        other = state.to_array()
        other[:3] += change
        assert map_overlap(other, map_of(shares)) <= best


def test_a_strip_half_as_wide_is_inside_but_overlaps_less():
    whole, half = CableState(0.0, 0.0, 40.0).to_array(), CableState(0.0, 0.0, 20.0).to_array()
    cable_map = map_of(0.9 * strip_shares(whole, EMPTY))
    inside = [bounded_log_odds(map_match(each, cable_map).inside_share) for each in (half, whole)]
    assert inside[0] == pytest.approx(inside[1], abs=0.1)
    assert map_overlap(half, cable_map) < map_overlap(whole, cable_map) - 0.5


def test_a_blurred_map_hardly_tells_thin_strips_from_each_other():
    thin, thinner = CableState(3.0, 0.2, 10.0).to_array(), CableState(3.0, 0.2, 5.0).to_array()
    blurred = map_of(cv2.GaussianBlur(strip_shares(thinner, EMPTY), (0, 0), 1.0))
    thin_match, thinner_match = map_match(thin, blurred), map_match(thinner, blurred)
    for one, other in zip(thin_match, thinner_match, strict=True):
        assert bounded_log_odds(one) == pytest.approx(bounded_log_odds(other), abs=0.15)
    wide = CableState(3.0, 0.2, 25.0).to_array()
    assert map_overlap(wide, blurred) < map_overlap(thinner, blurred) - 0.3


@pytest.mark.parametrize("width", [6.0, 7.0])
@pytest.mark.parametrize("angle", [0.0, 0.6, 1.5])
def test_a_thin_strip_matches_a_sharp_map_of_it_better_than_one_beside_it(width, angle):
    thin = CableState(3.0, angle, width).to_array()
    sharp = map_of(strip_shares(thin, EMPTY))
    beside = CableState(3.0 + width, angle, width).to_array()
    # Three quarters, which a strip of three cells about it does not reach.
    assert map_overlap(thin, sharp) > math.log(0.75 / 0.25)
    assert map_overlap(beside, sharp) < map_overlap(thin, sharp) - 1.0


def test_a_map_of_half_the_probability_has_half_of_it_inside():
    whole = CableState(0.0, 0.0, 40.0).to_array()
    cable_map = map_of(0.5 * strip_shares(whole, EMPTY))
    assert map_match(whole, cable_map).inside_share == pytest.approx(0.5, abs=1e-6)
    # Twice a half of the strip over a half of it and the whole.
    assert map_overlap(whole, cable_map) == pytest.approx(
        math.log((2 / 3 + 0.01) / (1 / 3 + 0.01)), abs=1e-6
    )


def test_a_strip_out_of_the_picture_matches_nothing():
    beyond, everywhere = (
        CableState(500.0, 0.0, 20.0).to_array(),
        map_of(np.full((ROWS, COLUMNS), 0.9)),
    )
    assert map_match(beyond, everywhere).inside_share == 0.0
    assert map_overlap(beyond, everywhere) < -4.0


def test_a_missing_map_matches_no_strip():
    assert map_match(CableState(0.0, 0.0, 20.0).to_array(), NO_MAP) == (0.0, 0.0)


@pytest.fixture(scope="module")
def shown():
    """A map that shows an upright cable in the middle."""
    probabilities = np.zeros((60, 80), np.float32)
    probabilities[:, 37:43] = 0.9
    return cable_map_of(probabilities, -158.0, 118.0, 4.0)


def test_a_particle_on_what_the_map_shows_weighs_more(shown):
    for state in (ON_IT, BESIDE):
        overlap = map_overlap(state, shown)
        found = map_log_ratio(state, shown, NOTHING_EXPECTED, WEIGHTS)
        assert found == pytest.approx(3.0 * overlap)
    assert map_overlap(ON_IT, shown) > 1.0 > -1.0 > map_overlap(BESIDE, shown)


def test_beyond_what_is_enough_a_better_overlap_weighs_no_more(shown):
    against = ExpectedOverlap(enough=1.0, expected=-math.inf)
    assert map_log_ratio(ON_IT, shown, against, WEIGHTS) == pytest.approx(3.0)


def test_without_a_map_no_particle_weighs_more(shown):
    assert map_log_ratio(ON_IT, NO_MAP, NOTHING_EXPECTED, WEIGHTS) == 0.0


def test_overlap_missing_to_that_of_the_expected_strip_is_subtracted(shown):
    against = overlap_of_expected(shown, ON_IT, is_kept=False)
    assert against == (math.inf, map_overlap(ON_IT, shown))
    on_it, beside = map_overlap(ON_IT, shown), map_overlap(BESIDE, shown)
    assert map_log_ratio(ON_IT, shown, against, WEIGHTS) == pytest.approx(3.0 * on_it)
    lacking = 2.0 * (on_it - beside)
    assert map_log_ratio(BESIDE, shown, against, WEIGHTS) == pytest.approx(3.0 * beside - lacking)
    less = against._replace(expected=beside)
    assert map_log_ratio(BESIDE, shown, less, WEIGHTS) == pytest.approx(3.0 * beside)


def test_in_a_kept_map_a_strip_that_matches_nearly_as_well_as_the_expected_one_is_as_good(shown):
    """How exactly the cable has moved since is not known: between such strips borders decide."""
    against = overlap_of_expected(shown, ON_IT, is_kept=True)
    assert against.enough == against.expected == map_overlap(ON_IT, shown) - SLACK
    aside, half = ON_IT.copy(), ON_IT.copy()
    aside[0] += 1.0
    half[[0, 2]] = -6.0, 12.0
    expected = map_log_ratio(ON_IT, shown, against, WEIGHTS)
    assert map_log_ratio(aside, shown, against, WEIGHTS) == expected
    assert map_log_ratio(half, shown, against, WEIGHTS) < expected - 1.0


def test_in_a_search_a_strip_loses_by_what_it_lacks_to_a_clear_one_of_the_map(shown):
    against = overlap_of_best(shown, np.stack((ON_IT, BESIDE)))
    best, beside = map_overlap(ON_IT, shown), map_overlap(BESIDE, shown)
    assert against == (math.inf, best - SLACK)
    assert map_log_ratio(ON_IT, shown, against, WEIGHTS) == pytest.approx(3.0 * best)
    lacking = 2.0 * (best - SLACK - beside)
    assert map_log_ratio(BESIDE, shown, against, WEIGHTS) == pytest.approx(3.0 * beside - lacking)


def test_no_overlap_is_expected_where_the_map_has_no_clear_strip(shown):
    assert overlap_of_best(shown, BESIDE[None]) == NOTHING_EXPECTED
    assert overlap_of_best(NO_MAP, np.zeros((0, 8))) == NOTHING_EXPECTED


def test_no_overlap_is_expected_without_a_map():
    assert overlap_of_expected(NO_MAP, ON_IT, is_kept=False) == NOTHING_EXPECTED
    assert overlap_of_expected(NO_MAP, ON_IT, is_kept=True) == NOTHING_EXPECTED


def kept_map_of(state: CableState) -> KeptMap:
    """The map of a frame that shows a strip and nothing else."""
    shares = strip_shares(state.to_array(), LARGE)
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


def test_cells_that_come_into_view_repeat_the_outermost_ones():
    """Else a cable that moves inwards would end before the edge."""
    along_the_edge = CableState(150.0, 0.0, 40.0, 0.0)
    moved = kept_map_of(along_the_edge).moved_to(CableState(110.0, 0.0, 40.0, 0.0).to_array())
    assert moved.probabilities[:, -1].min() == 1.0


def test_a_map_that_is_too_old_does_not_count():
    """Else one would go on for as long as the network is not to look, an hour for instance."""
    state = CableState(0.0, 0.0, 24.0, 0.0)
    kept = kept_map_of(state)
    young, old = (replace(kept, seconds=LONGEST_KEPT - less) for less in (0.01, 0.0))
    assert overlap(state, young.moved_to(state.to_array())) > 2.0
    assert old.moved_to(state.to_array()) is NO_MAP


@pytest.mark.parametrize(("seconds", "least", "most"), [(0.04, 0.5, 1.0), (1.0, 8.0, 9.0)])
def test_the_borders_of_a_new_map_count_more_the_older_the_kept_map_is(seconds, least, most):
    kept = replace(kept_map_of(CableState(0.0, 0.0, 24.0, 0.0)), seconds=seconds)
    found = kept.smoothed(MapBorders(10.0, 0.0, 6.0))
    assert least < found.widening < most
    assert found.right_rim == pytest.approx(0.6 * found.widening)


def test_without_a_kept_map_the_borders_are_those_of_the_new_one():
    assert NO_KEPT_MAP.moved_to(CableState(0.0, 0.0, 24.0, 0.0).to_array()) is NO_MAP
    assert NO_KEPT_MAP.smoothed(MapBorders(10.0, 0.0, 6.0)) == (10.0, 0.0, 6.0)
