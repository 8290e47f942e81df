from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.initial_state_text import format_initial_state, parse_initial_state
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


@given(
    NUMBERS,
    st.floats(-math.pi, math.pi),
    st.floats(1e-300, 1e300),
    st.floats(-math.pi / 2, math.pi / 2),
)
def test_a_written_state_is_read_back_exactly(d, alpha, w, beta):
    state = CableState(d, alpha, w, beta)
    assert parse_initial_state(format_initial_state(state)) == state


@pytest.mark.parametrize("text", ["0,45,30,0", "0,-3.2,30,0", "0,0.1,30,5"])
def test_degrees_are_refused(text):
    with pytest.raises(ParameterError, match="radians"):
        parse_initial_state(text)


@pytest.mark.parametrize("text", ["random", " random "])
def test_random_is_no_state(text):
    assert parse_initial_state(text) is None


def test_spaces_do_no_harm():
    assert parse_initial_state(" -5, 0.1 ,30,0 ") == CableState(-5.0, 0.1, 30.0, 0.0)


@pytest.mark.parametrize(
    "text",
    ["", "Random", "truth", "1,2,3", "1,2,3,4,5", "1,2,x,4", "nan,0,30,0", "0,inf,30,0", "0,0,0,0",
     "0,0,-3,0", "1 2 3 4", "a\nb"],
)  # fmt: skip
def test_anything_else_is_refused_in_one_line(text):
    with pytest.raises(ParameterError, match="d,alpha,w,beta") as caught:
        parse_initial_state(text)
    assert "\n" not in str(caught.value)
