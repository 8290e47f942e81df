from __future__ import annotations

import numpy as np
import pytest

import cable_tracker.cable.model.state as state_module
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE, STATE_SYMBOLS, CableState


def test_columns_symbols_and_fields_are_in_one_order():
    state = CableState(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)
    assert state.to_array().tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    columns = [getattr(state_module, name.upper()) for name in CableState.__slots__]
    assert columns == list(range(STATE_SIZE))
    assert len(STATE_SYMBOLS) == STATE_SIZE == 2 * POSE_SIZE == 8


def test_an_array_gives_the_state_back():
    state = CableState(1.5, -0.2, 30.0, 0.01, -2.0, 0.3, 4.0, -0.1)
    assert CableState.from_array(state.to_array()) == state
    assert CableState.from_array(np.array([1.5, -0.2, 30.0, 0.01])) == CableState(
        1.5, -0.2, 30.0, 0.01
    )


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_state_is_finite_only_if_every_component_is(value):
    assert CableState.from_array(np.ones(STATE_SIZE)).is_finite()
    for column in range(STATE_SIZE):
        values = np.ones(STATE_SIZE)
        values[column] = value
        assert not CableState.from_array(values).is_finite()


MOVING = CableState(8.0, 0.2, 16.0, 0.1, 4.0, 0.3, -12.0, 0.4)


def test_in_a_larger_image_lengths_grow_and_angles_do_not():
    assert MOVING.scaled(0.25) == CableState(2.0, 0.2, 4.0, 0.1, 1.0, 0.3, -3.0, 0.4)


def test_at_rest_a_cable_is_where_it_was():
    assert MOVING.at_rest() == CableState(8.0, 0.2, 16.0, 0.1)
