from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cable_tracker.cable.measure.map.cable_map import (
    NO_MAP,
    cable_map_of,
    map_overlap,
    strip_shares,
)
from cable_tracker.cable.measure.map.map_strips import strips_of_map
from cable_tracker.cable.model.geometry import relative_direction
from cable_tracker.cable.model.state import CableState
from cable_tracker.particle_filter.existence import probability_of

EMPTY = cable_map_of(np.zeros((60, 80), np.float32), -158.0, 118.0, 4.0)
SMALL = cable_map_of(np.zeros((30, 40), np.float32), -78.0, 58.0, 4.0)
CABLE, OTHER = CableState(-30.0, 0.4, 40.0, 0.05), CableState(60.0, 0.3, 16.0)


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


def test_of_two_strips_the_larger_one_comes_first():
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
