from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.belief import RememberedCable, initial_belief
from cable_tracker.cable.hypotheses.claim import (
    APPEARANCE_SHARE,
    CRISP,
    CRISP_WIDTH,
    LEAST_APPEARANCE,
    LEAST_FACTOR,
    MAPPED_SHARE,
    MOST_APPEARANCE,
    MOST_FACTOR,
    MOST_MAPPED,
    UNLIKE_A_CABLE,
    USUAL_WIDTH,
    are_borders_in_view,
    claim_score_by_map,
    claim_score_by_width,
    is_lost_in_map,
    is_new_clear,
    leading_evidence,
    needed_clearness,
)
from cable_tracker.cable.hypotheses.evidence_correction import ORDINARY_APPEARANCE
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters()
SIZE = (320, 240)
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
USUAL = USUAL_WIDTH * PARAMETERS.thin_width
MEMORY = RememberedCable(LEADER[:4], 0.0, 100.0, math.log(30.0), tracked_time=60.0)


@given(st.floats(8.0, 200.0), st.floats(0.0, 100.0))
def test_a_first_claim_of_another_width_needs_more_the_sooner_the_more(width, seconds):
    hypotheses = initial_belief(CableState(0.0, 0.0, width).to_array()[None], 0.9).hypotheses
    needed = needed_clearness(width, PARAMETERS, 1.0)

    def is_clear(factor, memory):
        clear = hypotheses._replace(
            scaled_clearness=factor * needed, appearance=ORDINARY_APPEARANCE
        )
        return is_new_clear(clear, memory, PARAMETERS, SIZE, 1.0)

    memory = replace(MEMORY, seconds=seconds)
    factor = 1.0 + memory.width_deviation(width, PARAMETERS) ** 2
    assert is_clear(1.001, None) and not is_clear(0.999, None)
    assert is_clear(1.001 * factor, memory) and not is_clear(0.999 * factor, memory)
    assert is_clear(1.001 * factor, replace(memory, seconds=seconds + 10.0))


@given(st.floats(0.5, 20.0), st.floats(3.0, 200.0), st.floats(-20.0, -0.01))
def test_what_the_map_says_is_nothing_like_a_cable_is_claimed_only_if_it_is_crisp_and_wide(
    clearness, width, beyond
):
    leader = CableState(10.0, 0.2, width).to_array()
    ripples = initial_belief(leader[None], 0.9).hypotheses._replace(
        scaled_clearness=clearness, appearance=UNLIKE_A_CABLE + beyond, weaker_border_mean=clearness
    )
    mapped = ripples._replace(is_mapped=True, overlap_share=1.0)
    is_crisp_and_wide = clearness >= CRISP and width >= CRISP_WIDTH * PARAMETERS.thin_width
    assert is_new_clear(mapped, None, PARAMETERS, SIZE, 1.0) == is_crisp_and_wide


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(1.0, 3.0))
def test_what_has_little_in_common_with_the_map_is_claimed_only_if_it_is_crisp(
    share, least, clearness
):
    hypotheses = initial_belief(LEADER[None], 0.9).hypotheses
    clear = hypotheses._replace(scaled_clearness=clearness, appearance=10.0, overlap_share=share)
    parameters = replace(PARAMETERS, overlap_to_find=least)
    is_lost = is_lost_in_map(clear._replace(is_mapped=True), parameters)
    assert is_lost == (share < least and clearness < CRISP)
    assert not is_lost_in_map(clear, parameters)


@given(st.sampled_from([8.0, 30.0, 150.0]), st.floats(-5.0, 20.0), st.booleans())
def test_a_strip_is_claimed_that_is_clear_by_its_borders_or_by_the_map(width, looks, is_mapped):
    assume(looks >= UNLIKE_A_CABLE or not is_mapped)
    leader = CableState(10.0, 0.2, width).to_array()
    hypotheses = initial_belief(leader[None], 0.9).hypotheses
    hypotheses = hypotheses._replace(appearance=looks, is_mapped=is_mapped, overlap_share=1.0)
    by_borders = needed_clearness(width, PARAMETERS, 1.0)
    by_borders -= claim_score_by_width(hypotheses, PARAMETERS, 1.0)
    by_map = PARAMETERS.evidence_to_find - claim_score_by_map(hypotheses)
    needed = min(by_borders, by_map) if is_mapped else by_borders
    for clearness in (needed - 1e-6, needed + 1e-6):
        looked_at = hypotheses._replace(scaled_clearness=clearness)
        assert is_new_clear(looked_at, None, PARAMETERS, SIZE, 1.0) == (clearness > needed)


@given(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(4.0, 200.0))
def test_better_looks_are_never_worth_less_and_within_limits(appearance, other, width):
    leader = CableState(10.0, 0.2, width).to_array()
    hypotheses = initial_belief(leader[None], 0.9).hypotheses

    def worth(of):
        looked_at = hypotheses._replace(appearance=of)
        return claim_score_by_width(looked_at, PARAMETERS, 1.0), claim_score_by_map(looked_at)

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
        appearance=UNLIKE_A_CABLE,
        scaled_clearness=PARAMETERS.evidence_to_find,
        overlap_share=1.0,
    )
    assert is_new_clear(looks._replace(is_mapped=True), None, PARAMETERS, SIZE, 1.0)
    assert not is_new_clear(looks, None, PARAMETERS, SIZE, 1.0)


def test_a_cable_of_the_usual_width_needs_what_the_parameter_says():
    assert needed_clearness(USUAL, PARAMETERS, 1.0) == PARAMETERS.evidence_to_find
    assert needed_clearness(2 * USUAL, PARAMETERS, 2.0) == PARAMETERS.evidence_to_find


def test_one_half_as_wide_needs_twice_as_much():
    needed = needed_clearness(USUAL / 2, PARAMETERS, 1.0)
    assert needed == pytest.approx(2 * PARAMETERS.evidence_to_find)


@given(st.floats(0.0, 1e4), st.floats(0.0, 1e4))
def test_a_wider_one_never_needs_more_and_there_are_limits(width, other):
    needed = [needed_clearness(each, PARAMETERS, 1.0) for each in sorted((width, other))]
    assert needed[0] >= needed[1]
    least, most = LEAST_FACTOR, MOST_FACTOR
    for each in needed:
        assert least <= each / PARAMETERS.evidence_to_find * (1 + 1e-9)
        assert each / PARAMETERS.evidence_to_find <= most * (1 + 1e-9)


@pytest.mark.parametrize("evidence", [0.0, -1.0])
def test_who_asks_for_nothing_gets_any_width(evidence):
    parameters = TrackerParameters(evidence_to_find=evidence)
    assert needed_clearness(4.0, parameters, 1.0) == evidence


@pytest.mark.parametrize(
    ("pose", "is_in_view"),
    [
        ((0.0, 0.0, 30.0, 0.0), True),
        ((0.0, 0.0, 220.0, 0.1), True),
        ((130.0, 0.0, 20.0, 0.0), True),
        ((90.0, 0.0, 180.0, 0.0), False),  # One edge through the middle.
        ((90.0, 0.0, 120.0, 0.0), False),  # The other along the picture's own.
        ((0.0, 1.57, 200.0, 0.0), True),
        ((80.0, 1.57, 180.0, 0.0), False),
        ((100.0, 0.8, 30.0, 0.0), True),
    ],
)
@pytest.mark.parametrize("scale", [0.5, 1.0, 4.0])
def test_a_single_edge_is_no_cable(pose, is_in_view, scale):
    state = CableState(*pose).scaled(scale).to_array()
    size = (round(320 * scale), round(240 * scale))
    assert are_borders_in_view(state, size) == is_in_view
    hypotheses = initial_belief(state[None], 0.9).hypotheses._replace(
        scaled_clearness=100.0, appearance=ORDINARY_APPEARANCE, weaker_border_mean=0.0
    )
    assert is_new_clear(hypotheses, None, PARAMETERS, size, size[0] / 320) == is_in_view
    both_clear = hypotheses._replace(weaker_border_mean=PARAMETERS.evidence_to_find)
    assert is_new_clear(both_clear, None, PARAMETERS, size, size[0] / 320)


@pytest.mark.parametrize("height", [100, 240, 960])
@pytest.mark.parametrize(
    ("pose", "is_in_view"),
    [
        ((0.0, 0.0, 400.0, 0.0), True),
        ((500.0, 0.0, 400.0, 0.0), False),  # One beyond the side.
        ((0.0, 0.0, 1400.0, 0.0), False),  # Both.
        ((0.0, math.pi / 2, 3000.0, 0.0), False),
    ],
)
def test_borders_in_view_are_told_in_flat_pictures_too(pose, is_in_view, height):
    state = CableState(*pose).to_array()
    assert are_borders_in_view(state, (1280, height)) == is_in_view


@given(st.floats(-150.0, 150.0), st.floats(-3.1, 3.1), st.floats(4.0, 200.0))
def test_mirrored_borders_are_as_much_in_view(distance, angle, width):
    pose = CableState(distance, angle, width, 0.0).to_array()
    turned = CableState(-distance, angle + math.pi, width, 0.0).to_array()
    mirrored = CableState(-distance, -angle, width, 0.0).to_array()
    is_in_view = are_borders_in_view(pose, SIZE)
    assert are_borders_in_view(turned, SIZE) == is_in_view
    assert are_borders_in_view(mirrored, SIZE) == is_in_view
