from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.belief import initial_belief
from cable_tracker.cable.hypotheses.first_claim import (
    APPEARANCE_SHARE,
    LEAST_APPEARANCE,
    MAPPED_SHARE,
    MOST_APPEARANCE,
    MOST_MAPPED,
    UNLIKE_A_CABLE,
    claim_score_by_borders,
    claim_score_by_map,
    is_new_clear,
    leading_evidence,
)
from cable_tracker.cable.hypotheses.predict.remembered_cable import RememberedCable
from cable_tracker.cable.hypotheses.weigh.evidence_correction import ORDINARY_APPEARANCE
from cable_tracker.cable.hypotheses.weigh.thin_strips import needed_clearness
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters()
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
MEMORY = RememberedCable(LEADER[:4], 0.0, 100.0, math.log(30.0), tracked_time=60.0)


@given(st.floats(8.0, 200.0), st.floats(0.0, 100.0))
def test_a_first_claim_of_another_width_needs_more_the_sooner_the_more(width, seconds):
    hypotheses = initial_belief(CableState(0.0, 0.0, width).to_array()[None], 0.9).hypotheses
    needed = needed_clearness(width, PARAMETERS, 320)

    def is_clear(factor, memory):
        clear = hypotheses._replace(
            scaled_clearness=factor * needed, appearance=ORDINARY_APPEARANCE
        )
        return is_new_clear(clear, memory, PARAMETERS, 320)

    memory = MEMORY.aged(seconds)
    factor = 1.0 + memory.width_deviation(width, PARAMETERS) ** 2
    assert is_clear(1.001, None) and not is_clear(0.999, None)
    assert is_clear(1.001 * factor, memory) and not is_clear(0.999 * factor, memory)
    assert is_clear(1.001 * factor, memory.aged(10.0))


@given(st.floats(0.0, 20.0), st.floats(-20.0, -0.01))
def test_what_the_map_says_is_nothing_like_a_cable_is_not_claimed_however_clear(clear, beyond):
    hypotheses = initial_belief(LEADER[None], 0.9).hypotheses
    ripples = hypotheses._replace(
        scaled_clearness=PARAMETERS.evidence_to_find + clear, appearance=UNLIKE_A_CABLE + beyond
    )
    assert not is_new_clear(ripples._replace(is_mapped=True), None, PARAMETERS, 320)


@given(st.sampled_from([8.0, 30.0, 150.0]), st.floats(UNLIKE_A_CABLE, 20.0), st.booleans())
def test_a_strip_is_claimed_that_is_clear_by_its_borders_or_by_the_map(width, looks, is_mapped):
    leader = CableState(10.0, 0.2, width).to_array()
    hypotheses = initial_belief(leader[None], 0.9).hypotheses
    hypotheses = hypotheses._replace(appearance=looks, is_mapped=is_mapped)
    by_borders = needed_clearness(width, PARAMETERS, 320)
    by_borders -= claim_score_by_borders(hypotheses, PARAMETERS, 320)
    by_map = PARAMETERS.evidence_to_find - claim_score_by_map(hypotheses)
    needed = min(by_borders, by_map) if is_mapped else by_borders
    for clearness in (needed - 1e-6, needed + 1e-6):
        looked_at = hypotheses._replace(scaled_clearness=clearness)
        assert is_new_clear(looked_at, None, PARAMETERS, 320) == (clearness > needed)


@given(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(4.0, 200.0))
def test_better_looks_are_never_worth_less_and_within_limits(appearance, other, width):
    leader = CableState(10.0, 0.2, width).to_array()
    hypotheses = initial_belief(leader[None], 0.9).hypotheses

    def worth(of):
        looked_at = hypotheses._replace(appearance=of)
        return claim_score_by_borders(looked_at, PARAMETERS, 320), claim_score_by_map(looked_at)

    (low, low_mapped), (high, high_mapped) = (worth(each) for each in sorted((appearance, other)))
    assert APPEARANCE_SHARE * LEAST_APPEARANCE - 1e-9 <= low <= high
    assert high <= APPEARANCE_SHARE * MOST_APPEARANCE + 1e-9
    assert low_mapped <= high_mapped <= MAPPED_SHARE * MOST_MAPPED + 1e-9


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-20.0, 20.0))
def test_a_hidden_border_counts_as_just_clear_enough_if_the_map_shows_the_cable(
    border_mean, clearness, looks
):
    hypotheses = initial_belief(LEADER[None], 0.9).hypotheses._replace(
        weaker_border_mean=border_mean, scaled_clearness=clearness, appearance=looks
    )
    assert leading_evidence(hypotheses, PARAMETERS) == border_mean
    mapped = leading_evidence(hypotheses._replace(is_mapped=True), PARAMETERS)
    assert border_mean <= mapped <= max(border_mean, PARAMETERS.evidence_to_find)
    if claim_score_by_map(hypotheses) >= PARAMETERS.evidence_to_find:
        assert mapped >= PARAMETERS.evidence_to_find


def test_a_thin_strip_that_looks_like_a_cable_needs_less_with_a_map():
    leader = CableState(10.0, 0.2, 8.0).to_array()
    looks = initial_belief(leader[None], 0.9).hypotheses._replace(
        appearance=ORDINARY_APPEARANCE, scaled_clearness=PARAMETERS.evidence_to_find
    )
    assert is_new_clear(looks._replace(is_mapped=True), None, PARAMETERS, 320)
    assert not is_new_clear(looks, None, PARAMETERS, 320)
