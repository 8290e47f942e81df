from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.belief import (
    Belief,
    RememberedCable,
    initial_belief,
    remember,
)
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
    POLARITY_DOUBT,
    UNLIKE_A_CABLE,
    USUAL_WIDTH,
    are_borders_in_view,
    belief_summary,
    claim_score_by_map,
    claim_score_by_width,
    is_lost_in_map,
    is_new_clear,
    leading_evidence,
    needed_clearness,
    updated_belief,
    updated_p_bright,
)
from cable_tracker.cable.hypotheses.conclusion import Conclusion
from cable_tracker.cable.hypotheses.evidence_correction import ORDINARY_APPEARANCE
from cable_tracker.cable.measure.borders.border_points import MINIMUM_LENGTH
from cable_tracker.cable.measure.map.cable_map import NO_KEPT_MAP, NO_MAP, KeptMap, MapBorders
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import probability_of

PARAMETERS = TrackerParameters()
SIZE = (320, 240)
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
USUAL = USUAL_WIDTH * PARAMETERS.thin_width
MEMORY = RememberedCable(LEADER[:4], 0.0, 100.0, math.log(30.0), tracked_time=60.0)
REMEMBERED = replace(remember(None, LEADER, (320, 240), 0.0, PARAMETERS, 1.0), tracked_time=60.0)
YOUNG = 0.5 * PARAMETERS.known_after
BEFORE = replace(initial_belief(LEADER[None], 0.9), known_time=YOUNG, faint_time=0.3)
CLEAR, FAINT = 100.0, -100.0
SHARES = st.floats(0.0, 1.0)


def concluded(clearness=CLEAR, border_mean=CLEAR, log_odds=5.0, goes_on=True) -> Conclusion:
    hypotheses = BEFORE.hypotheses._replace(
        scaled_clearness=clearness, weaker_border_mean=border_mean
    )
    return Conclusion(
        LEADER[None],
        np.zeros(1),
        hypotheses,
        np.array([log_odds]),
        1.0,
        probability_of(log_odds),
        0.0,
        goes_on,
    )


def updated(found: Conclusion, before: Belief = BEFORE) -> Belief:
    was_known = before.is_known(PARAMETERS)
    return updated_belief(before, found, 0.1, PARAMETERS, (320, 240), 1.0, was_known=was_known)


KEPT = KeptMap(NO_MAP, LEADER[:4], MapBorders(10.0, 0.0, 6.0), 0.2)


def test_a_clear_cable_is_remembered_and_its_time_grows():
    belief = updated(concluded())
    assert belief.known_time == pytest.approx(YOUNG + 0.1)
    assert belief.faint_time == 0.0
    assert belief.p_bright > BEFORE.p_bright
    np.testing.assert_array_equal(belief.memory.pose, LEADER[:4])
    assert math.exp(belief.memory.log_width) == pytest.approx(30.0)


def test_from_what_could_not_be_claimed_nothing_is_learnt():
    belief = updated(concluded(clearness=FAINT))
    assert belief.known_time == YOUNG
    assert belief.faint_time == pytest.approx(0.4)
    assert belief.p_bright == BEFORE.p_bright
    assert belief.memory is None


def test_a_known_cable_may_be_faint_as_long_as_it_would_be_kept():
    known = replace(BEFORE, known_time=PARAMETERS.known_after)
    kept, lost = (updated(concluded(FAINT, mean), known) for mean in (CLEAR, FAINT))
    assert (kept.faint_time, lost.faint_time) == (0.0, pytest.approx(0.4))
    assert kept.memory is not None


def test_another_hypothesis_or_an_absent_one_is_not_known():
    assert updated(concluded(goes_on=False)).known_time == 0.0
    assert updated(concluded(log_odds=-2.0)).known_time == 0.0


def test_a_map_is_kept_while_the_hypothesis_of_its_frame_goes_on():
    """It would be moved by how far another one is from that."""
    before = replace(BEFORE, kept_map=KEPT)
    assert updated(concluded(), before).kept_map is KEPT
    assert updated(concluded(goes_on=False), before).kept_map is NO_KEPT_MAP


def test_a_belief_that_ages_remembers_what_is_older():
    memory = RememberedCable(LEADER[:4], 0.0, 50.0, math.log(30.0), seconds=1.0)
    belief = replace(BEFORE, memory=memory, kept_map=KEPT)
    aged = belief.aged(0.1)
    assert (aged.memory.seconds, aged.kept_map.seconds) == (pytest.approx(1.1), pytest.approx(0.3))
    assert BEFORE.aged(0.1).memory is None
    assert aged.aged(0.2).memory.seconds == pytest.approx(1.3)


def test_a_given_cable_stays_given_while_frames_take_it_for_a_cable():
    given = replace(BEFORE, is_given=True)
    assert updated(concluded(), given).is_given
    assert not updated(concluded(goes_on=False), given).is_given
    assert not updated(concluded(log_odds=-2.0), given).is_given
    assert not updated(concluded()).is_given


def test_from_another_hypothesis_than_the_known_one_nothing_is_learnt_unless_it_is_clear():
    known = replace(BEFORE, known_time=PARAMETERS.known_after)
    faint, clear = (updated(concluded(c, goes_on=False), known) for c in (FAINT, CLEAR))
    assert faint.memory is None
    assert faint.faint_time == pytest.approx(0.4)
    assert clear.memory is not None


def test_a_strip_lost_in_the_map_is_clear_only_if_an_earlier_frame_took_it_for_a_cable():
    found = concluded(clearness=0.9 * CRISP)
    smeared = found.hypotheses._replace(is_mapped=True, appearance=5.0, overlap_share=0.1)
    found, other = (found._replace(hypotheses=smeared, goes_on=each) for each in (True, False))
    assert updated(found).is_clear
    assert not updated(other).is_clear
    assert not updated(found, replace(BEFORE, known_time=0.0)).is_clear
    alone = smeared._replace(overlap_share=0.9)
    assert updated(other._replace(hypotheses=alone)).is_clear


def test_a_leader_that_is_clear_as_a_new_one_stays_so_although_its_width_is_learnt_from():
    """After a long time without a cable, any width may come; it is not judged by itself."""
    narrow = RememberedCable(LEADER[:4], 0.0, 100.0, math.log(12.0), tracked_time=60.0)
    forgotten = replace(BEFORE, memory=replace(narrow, seconds=100.0 * PARAMETERS.width_memory))
    belief = updated(concluded(1.5), forgotten)
    assert belief.memory.seconds == 0.0
    assert belief.is_clear
    assert not updated(concluded(1.5), replace(BEFORE, memory=narrow)).is_clear


@given(SHARES, SHARES, SHARES, SHARES, st.floats(0.0, 100.0))
def test_the_polarity_is_never_beyond_doubt(before, found, presence, memory, dt):
    after = updated_p_bright(before, found, presence, memory, dt)
    assert POLARITY_DOUBT <= after <= 1.0 - POLARITY_DOUBT


def test_a_frame_without_a_cable_leaves_the_polarity_unknown():
    assert updated_p_bright(0.8, 0.0, 0.0, 1.0, 0.04) == pytest.approx(0.8)
    assert updated_p_bright(0.8, 0.1, 1.0, 1.0, 0.04) == pytest.approx(0.1)


def test_the_polarity_is_forgotten_with_time():
    soon, late = (updated_p_bright(0.9, 0.9, 0.0, 0.9, dt) for dt in (0.04, 4.0))
    assert 0.5 < late < soon < 0.9


def summary(
    presence=0.99, border_mean=CLEAR, clearness=CLEAR, length=MINIMUM_LENGTH, leader=LEADER, **known
):
    belief = replace(initial_belief(leader[None], presence), **known)
    hypotheses = belief.hypotheses._replace(
        covariance=np.eye(8),
        weaker_border_mean=border_mean,
        scaled_clearness=clearness,
        appearance=ORDINARY_APPEARANCE,
        visible_length=length,
    )
    is_clear = is_new_clear(hypotheses, belief.memory, PARAMETERS, (320, 240), 1.0)
    evidence = leading_evidence(hypotheses, PARAMETERS)
    belief = replace(belief, hypotheses=hypotheses, evidence=evidence, is_clear=is_clear)
    return belief_summary(belief, PARAMETERS, 1.0)


@pytest.mark.parametrize(
    ("changes", "claim", "new_claim", "keeping"),
    [
        ({}, True, True, True),
        ({"clearness": FAINT, "known_time": 0.04}, True, False, True),
        ({"clearness": FAINT}, False, False, False),
        ({"border_mean": FAINT}, False, False, False),
        ({"presence": 0.01}, False, False, False),
        ({"length": MINIMUM_LENGTH - 0.1}, False, False, False),
    ],
)
def test_a_claim_needs_presence_length_and_evidence_and_a_new_one_clearness(
    changes, claim, new_claim, keeping
):
    found = summary(**changes)
    assert (found.supports_claim, found.supports_new_claim) == (claim, new_claim)
    assert found.supports_keeping == keeping
    np.testing.assert_allclose(found.hypotheses[0].state.to_array(), LEADER, atol=1e-5)


@pytest.mark.parametrize(
    ("leader", "seconds", "claim"),
    [
        (CableState(10.0, 0.2, 30.0), 0.0, True),
        (CableState(60.0, 0.2, 30.0), 0.04, False),
        (CableState(60.0, 0.2, 30.0), 1.0, True),
        (CableState(10.0, 0.2, 14.0), 1.0, False),
    ],
    ids=["there", "beside it", "where it may be by now", "narrower"],
)
def test_a_faint_cable_is_claimed_only_near_the_remembered_place_and_width(leader, seconds, claim):
    found = summary(
        clearness=FAINT,
        leader=leader.to_array(),
        memory=replace(REMEMBERED, seconds=seconds),
    )
    assert found.supports_claim == found.supports_keeping == claim
    assert found.contradicts_claim != claim
    assert not found.supports_new_claim


def test_without_a_memory_there_is_nothing_that_a_leader_could_differ_from():
    assert not summary(clearness=FAINT).contradicts_claim


def test_a_cable_that_is_not_in_view_contradicts_a_claim():
    assert summary(presence=0.4, known_time=1.0).contradicts_claim
    assert not summary(presence=0.45, known_time=1.0).contradicts_claim


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
def test_a_strip_unlike_a_cable_by_the_map_is_claimed_only_if_crisp_and_wide(
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
def test_a_strip_with_little_overlap_with_the_map_is_lost_in_it_unless_crisp(
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


def test_a_cable_of_the_usual_width_needs_the_evidence_of_the_parameter():
    assert needed_clearness(USUAL, PARAMETERS, 1.0) == PARAMETERS.evidence_to_find
    assert needed_clearness(2 * USUAL, PARAMETERS, 2.0) == PARAMETERS.evidence_to_find


def test_a_cable_half_as_wide_needs_twice_the_evidence():
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
def test_without_evidence_to_find_the_width_does_not_matter(evidence):
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
def test_borders_in_view_are_reported_in_flat_pictures_too(pose, is_in_view, height):
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
