from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.geometry import (
    Borders,
    borders_cross_inside,
    project_borders,
    states_from_borders,
)
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.border_lines import BorderLines
from cable_tracker.detection.line_pairs import (
    GAP_FACTOR,
    MOST_DETECTIONS,
    REGION_SHARE,
    PairLimits,
    pair_limits,
    pair_lines,
    plausible_pairs,
)
from cable_tracker.detection.search_region import SearchRegion

SIZE = (320, 240)
LIMITS = PairLimits(8.0, 120.0, np.deg2rad(15.0))


def lines_of(state: CableState, *, dark=False, supports=(0.9, 0.4)) -> BorderLines:
    """The borders of a cable, each with its normal to the brighter side."""
    borders = project_borders(state.to_array()[None, :])
    (left, right), (low, high) = borders.angles[0], borders.offsets[0]
    if dark:
        return BorderLines(
            np.array([left + np.pi, right]), np.array([-low, high]), np.array(supports)
        )
    return BorderLines(np.array([left, right + np.pi]), np.array([low, -high]), np.array(supports))


CABLES = st.builds(
    CableState,
    distance=st.floats(-100, 100),
    angle=st.floats(-1.57, 1.57),
    width=st.floats(9, 110),
    skew=st.floats(-0.2, 0.2),
).filter(lambda cable: not borders_cross_inside(cable.to_array(), SIZE))


@given(truth=CABLES, dark=st.booleans(), swap=st.booleans(), turns=st.integers(-1, 1))
def test_the_borders_of_any_cable_give_the_cable(truth, dark, swap, turns):
    lines = lines_of(truth, dark=dark)
    if swap:
        lines = lines.taken(np.array([1, 0]))
    lines = BorderLines(lines.angles + 2 * np.pi * turns, lines.offsets, lines.supports)
    (found,) = pair_lines(lines, SIZE, None, 0.1, LIMITS)
    np.testing.assert_allclose(found.state.to_array(), truth.to_array(), atol=1e-6)


def test_the_score_is_the_geometric_mean_of_the_supports():
    (found,) = pair_lines(lines_of(CableState(0.0, 0.0, 30.0)), SIZE, None, 0.1, LIMITS)
    assert found.score == pytest.approx(0.6)


@given(
    angle=st.floats(-3.1, 3.1),
    turn=st.floats(-0.3, 0.3),
    offsets=st.tuples(*[st.floats(-99, 99)] * 2),
)
def test_a_cable_between_two_lines_has_the_lines_as_borders(angle, turn, offsets):
    other = angle + np.pi + turn
    places, _ = plausible_pairs(
        np.array([angle, other]),
        np.array(offsets),
        np.ones(2),
        PairLimits(0.0, 1e12, 0.3),
        (1e-6, 0.0),
    )
    # The second line with its normal turned round; left comes first along the normal.
    turned = np.array([[angle, offsets[0]], [angle + turn, -offsets[1]]])
    left, right = turned[np.argsort(turned[:, 1], kind="stable")]
    borders = Borders(np.array([[left[0], right[0]]]), np.array([[left[1], right[1]]]))
    expected = states_from_borders(borders)[0]
    found = places[0]
    half_turns = round((expected[1] - found[1]) / np.pi)
    sign = -1.0 if half_turns % 2 else 1.0
    assert found[1] + half_turns * np.pi == pytest.approx(expected[1], abs=1e-9)
    assert -np.pi / 2 < found[1] <= np.pi / 2
    assert found[0] == pytest.approx(sign * expected[0], abs=1e-6)
    assert found[2] == pytest.approx(expected[2], abs=1e-6)
    assert found[3] == pytest.approx(sign * expected[3], abs=1e-9)


def joined(*parts) -> BorderLines:
    return BorderLines(
        np.concatenate([part.angles for part in parts]),
        np.concatenate([part.offsets for part in parts]),
        np.concatenate([part.supports for part in parts]),
    )


@pytest.mark.parametrize("dark", [True, False])
def test_the_gap_between_two_strips_ranks_below_the_strips(dark):
    strips = [CableState(-60.0, 0.0, 20.0), CableState(50.0, 0.0, 24.0)]
    lines = joined(*(lines_of(strip, dark=dark, supports=(0.8, 0.8)) for strip in strips))
    found = pair_lines(lines, SIZE, None, 0.1, LIMITS)
    widths = [detection.state.width for detection in found]
    assert sorted(np.round(widths[:2])) == [20.0, 24.0]
    gap = next(detection for detection in found if detection.state.width == pytest.approx(88.0))
    assert gap.score == pytest.approx(0.8 * GAP_FACTOR)


def test_a_shadow_on_one_side_makes_no_gap_of_a_cable():
    cable = CableState(0.0, 0.0, 60.0)
    shadow = BorderLines(np.array([0.0]), np.array([45.0]), np.array([0.7]))
    found = pair_lines(
        joined(lines_of(cable, supports=(0.8, 0.8)), shadow), SIZE, None, 0.1, LIMITS
    )
    assert found[0].state.width == pytest.approx(60.0)
    assert found[0].score == pytest.approx(0.8)


def test_faint_lines_to_both_sides_make_no_gap_of_a_cable():
    cable = CableState(0.0, 0.0, 60.0)
    clutter = BorderLines(np.array([0.0, np.pi]), np.array([45.0, 45.0]), np.array([0.3, 0.3]))
    found = pair_lines(
        joined(lines_of(cable, supports=(0.8, 0.8)), clutter), SIZE, None, 0.1, LIMITS
    )
    assert found[0].state.width == pytest.approx(60.0)
    assert found[0].score == pytest.approx(0.8)


def test_limits_cover_what_a_tracker_follows():
    parameters = TrackerParameters(width_minimum=6.0, width_maximum=250.0, skew_limit=12.0)
    limits = pair_limits(parameters)
    assert (limits.narrowest, limits.widest) == (6.0, 250.0)
    assert np.rad2deg(limits.most_skew) == pytest.approx(12.0)


@pytest.mark.parametrize(("width", "found"), [(30.0, 0), (90.0, 1)])
def test_borders_that_cross_inside_the_picture_are_no_cable(width, found):
    # They meet w / (2 tan beta) from the centre, which is 120 px high.
    cable = CableState(0.0, 0.0, width, np.deg2rad(12.0))
    assert len(pair_lines(lines_of(cable), SIZE, None, 0.1, LIMITS)) == found


@pytest.mark.parametrize("width", [7.0, 130.0])
def test_too_narrow_and_too_wide_pairs_are_no_cables(width):
    assert pair_lines(lines_of(CableState(0.0, 0.0, width)), SIZE, None, 0.1, LIMITS) == []


def test_borders_that_are_far_from_parallel_are_no_cable():
    assert pair_lines(lines_of(CableState(0.0, 0.0, 40.0, 0.4)), SIZE, None, 0.1, LIMITS) == []


def test_lines_of_the_same_contrast_are_no_cable():
    lines = BorderLines(np.zeros(2), np.array([-20.0, 20.0]), np.ones(2))
    assert pair_lines(lines, SIZE, None, 0.1, LIMITS) == []


def test_a_weak_pair_needs_a_region_that_expects_it():
    cable = CableState(5.0, 0.1, 30.0)
    lines = lines_of(cable, supports=(0.3, 0.3))
    region = SearchRegion(cable, 5.0, 0.1, 5.0)
    elsewhere = SearchRegion(CableState(60.0, 0.1, 30.0), 5.0, 0.1, 5.0)
    assert pair_lines(lines, SIZE, None, 0.4, LIMITS) == []
    assert len(pair_lines(lines, SIZE, region, 0.4, LIMITS)) == 1
    assert pair_lines(lines, SIZE, region, 0.31 / REGION_SHARE, LIMITS) == []
    assert pair_lines(lines, SIZE, elsewhere, 0.4, LIMITS) == []


def test_the_best_pair_comes_first_and_not_all_are_returned(rng):
    count = 20
    lines = BorderLines(
        np.tile([0.0, np.pi], count),
        rng.uniform(-60, 60, 2 * count),
        rng.uniform(0.2, 1, 2 * count),
    )
    scores = [found.score for found in pair_lines(lines, SIZE, None, 0.1, LIMITS)]
    assert len(scores) == MOST_DETECTIONS
    assert scores == sorted(scores, reverse=True)


def test_fewer_than_two_lines_give_nothing():
    nothing = np.zeros(0)
    assert pair_lines(BorderLines(nothing, nothing, nothing), SIZE, None, 0.1, LIMITS) == []
    assert (
        pair_lines(BorderLines(np.zeros(1), np.zeros(1), np.ones(1)), SIZE, None, 0.1, LIMITS) == []
    )
