from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.cable.model import geometry

pytest.importorskip("numba")

from cable_tracker.cable.compiled.geometry import (
    sine_and_cosine,
    unwrap_states,
    wrap_states,
    wrapped_angle,
)

STATES = arrays(np.float64, st.tuples(st.integers(0, 20), st.just(8)), elements=st.floats(-50, 50))
ANGLES = st.floats(-20, 20)
TURNED = np.array([-1, 1, 1, -1, -1, 1, 1, -1])
ROUNDING = 1e-13
"""Of an angle of a few turns; at the edge of a chart it may say which way a line is written."""


def assert_same_lines(found, expected, reference) -> None:
    """The same cables, (N, 8) each, and written alike but for those at the edge of the chart."""
    turns = np.rint((found[:, 1] - expected[:, 1]) / np.pi)
    at_edge = np.abs(np.abs(expected[:, 1] - reference) - np.pi / 2) < ROUNDING
    assert ((turns == 0.0) | (at_edge & (np.abs(turns) == 1.0))).all()
    again = np.where(turns[:, None] == 0.0, found, found * TURNED)
    again[:, 1] -= turns * np.pi
    np.testing.assert_allclose(again[:, 1], expected[:, 1], rtol=0.0, atol=ROUNDING)
    others = [0, *range(2, 8)]
    np.testing.assert_array_equal(again[:, others], expected[:, others])


@given(STATES, ANGLES)
def test_cables_are_written_alike(states, reference):
    assert_same_lines(
        unwrap_states(states, reference), geometry.unwrap_states(states, reference), reference
    )
    assert_same_lines(wrap_states(states), geometry.wrap_states(states), 0.0)


@given(st.one_of(ANGLES, st.sampled_from([-math.pi / 2, math.pi / 2, math.pi, -3 * math.pi / 2])))
def test_angles_are_wrapped_alike_also_at_the_wrap(angle):
    assert -math.pi / 2 < wrapped_angle(angle) <= math.pi / 2
    state = np.array([[1.0, angle, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]])
    assert wrap_states(state)[0, 1] == wrapped_angle(angle)
    assert_same_lines(wrap_states(state), geometry.wrap_states(state), 0.0)


def test_the_states_given_are_not_changed():
    states = np.full((2, 8), 3.0)
    wrap_states(states)
    np.testing.assert_array_equal(states, 3.0)


@given(st.floats(-10.0, 10.0))
def test_sine_and_cosine_are_exact(angle):
    expected = (math.sin(angle), math.cos(angle))
    assert sine_and_cosine(angle) == pytest.approx(expected, abs=4e-15)
