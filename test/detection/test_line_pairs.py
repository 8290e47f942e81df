from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.geometry import project_borders
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.border_lines import BorderLines
from cable_tracker.detection.line_pairs import MOST_DETECTIONS, REGION_SHARE, pair_lines
from cable_tracker.detection.search_region import SearchRegion

SIZE = (320, 240)


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
)


@given(truth=CABLES, dark=st.booleans(), swap=st.booleans(), turns=st.integers(-1, 1))
def test_the_borders_of_any_cable_give_the_cable(truth, dark, swap, turns):
    lines = lines_of(truth, dark=dark)
    if swap:
        lines = lines.taken(np.array([1, 0]))
    lines = BorderLines(lines.angles + 2 * np.pi * turns, lines.offsets, lines.supports)
    (found,) = pair_lines(lines, SIZE, None, 0.1)
    np.testing.assert_allclose(found.state.to_array(), truth.to_array(), atol=1e-6)


def test_the_score_is_the_geometric_mean_of_the_supports():
    (found,) = pair_lines(lines_of(CableState(0.0, 0.0, 30.0)), SIZE, None, 0.1)
    assert found.score == pytest.approx(0.6)


@pytest.mark.parametrize("width", [7.0, 130.0])
def test_too_narrow_and_too_wide_pairs_are_no_cables(width):
    assert pair_lines(lines_of(CableState(0.0, 0.0, width)), SIZE, None, 0.1) == []


def test_borders_that_are_far_from_parallel_are_no_cable():
    assert pair_lines(lines_of(CableState(0.0, 0.0, 40.0, 0.4)), SIZE, None, 0.1) == []


def test_lines_of_the_same_contrast_are_no_cable():
    lines = BorderLines(np.zeros(2), np.array([-20.0, 20.0]), np.ones(2))
    assert pair_lines(lines, SIZE, None, 0.1) == []


def test_a_weak_pair_needs_a_region_that_expects_it():
    cable = CableState(5.0, 0.1, 30.0)
    lines = lines_of(cable, supports=(0.3, 0.3))
    region = SearchRegion(cable, 5.0, 0.1, 5.0)
    elsewhere = SearchRegion(CableState(60.0, 0.1, 30.0), 5.0, 0.1, 5.0)
    assert pair_lines(lines, SIZE, None, 0.4) == []
    assert len(pair_lines(lines, SIZE, region, 0.4)) == 1
    assert pair_lines(lines, SIZE, region, 0.31 / REGION_SHARE) == []
    assert pair_lines(lines, SIZE, elsewhere, 0.4) == []


def test_the_best_pair_comes_first_and_not_all_are_returned(rng):
    count = 20
    lines = BorderLines(
        np.tile([0.0, np.pi], count),
        rng.uniform(-60, 60, 2 * count),
        rng.uniform(0.2, 1, 2 * count),
    )
    scores = [found.score for found in pair_lines(lines, SIZE, None, 0.1)]
    assert len(scores) == MOST_DETECTIONS
    assert scores == sorted(scores, reverse=True)


def test_fewer_than_two_lines_give_nothing():
    nothing = np.zeros(0)
    assert pair_lines(BorderLines(nothing, nothing, nothing), SIZE, None, 0.1) == []
    assert pair_lines(BorderLines(np.zeros(1), np.zeros(1), np.ones(1)), SIZE, None, 0.1) == []
