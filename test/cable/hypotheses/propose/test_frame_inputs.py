from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.propose.frame_inputs import (
    FIRST_POWER,
    annealing_power,
    beside_a_known_cable,
    frame_config,
    refined_counts,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters


def test_beside_a_known_cable_other_strips_count_less_and_the_map_where_it_shows_more():
    parameters = TrackerParameters()
    search = frame_config(parameters, 4.0, (320, 240))
    known = beside_a_known_cable(search, parameters)
    assert known.is_known and not search.is_known
    assert known.map_weights.overlap < search.map_weights.overlap
    assert sum(known.map_weights) == sum(search.map_weights)
    assert known.evidence_limit == parameters.evidence_limit_known
    assert search.evidence_limit == parameters.evidence_limit
    changed = {"evidence_limit": None, "is_known": None, "map_weights": None}
    for before, after in zip(search._replace(**changed), known._replace(**changed), strict=True):
        assert before is after


@given(st.integers(1, 6))
def test_the_power_of_the_likelihood_rises_round_by_round_to_one(rounds):
    powers = [annealing_power(number, rounds) for number in range(rounds)]
    assert powers[0] == pytest.approx(FIRST_POWER)
    assert powers == sorted(powers)
    if rounds > 1:
        assert powers[-1] == 1.0


@given(st.integers(1, 4))
def test_the_rounds_share_all_and_the_last_has_most(rounds):
    parameters = TrackerParameters(refinement_rounds=rounds)
    refined = parameters.refinement_share * parameters.particle_count
    counts = refined_counts(parameters)
    assert len(counts) == rounds
    assert refined - rounds <= counts.sum() <= refined
    assert counts.max() == counts[-1]


def test_without_a_round_none_is_drawn_in_any():
    assert len(refined_counts(TrackerParameters(refinement_rounds=0))) == 0
