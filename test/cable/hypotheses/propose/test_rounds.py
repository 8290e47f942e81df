from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.propose.rounds import (
    FIRST_POWER,
    annealing_power,
    round_weights,
)


@given(st.integers(1, 6))
def test_the_power_of_the_likelihood_rises_round_by_round_to_one(rounds):
    powers = [annealing_power(number, rounds) for number in range(rounds)]
    assert powers[0] == pytest.approx(FIRST_POWER)
    assert powers == sorted(powers)
    if rounds > 1:
        assert powers[-1] == 1.0


@given(st.integers(1, 6))
def test_the_rounds_share_all_and_the_last_has_most(rounds):
    weights = round_weights(rounds)
    assert len(weights) == rounds
    assert sum(weights) == pytest.approx(1.0)
    assert max(weights) == weights[-1]
    assert round_weights(0) == []
