from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.belief import initial_belief
from cable_tracker.cable.hypotheses.claim_support import (
    APPEARANCE_SHARE,
    LEAST_APPEARANCE,
    MAPPED_SHARE,
    MOST_APPEARANCE,
    MOST_MAPPED,
    belief_summary,
    clearness_by_borders,
    clearness_by_map,
    is_new_clear,
    leading_evidence,
)
from cable_tracker.cable.hypotheses.evidence_correction import ORDINARY_APPEARANCE
from cable_tracker.cable.hypotheses.remembered_cable import remember
from cable_tracker.cable.hypotheses.thin_strips import needed_clearness
from cable_tracker.cable.hypotheses.width_prior import WidthPrior
from cable_tracker.cable.measure.border_points import MINIMUM_LENGTH
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters()
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
CLEAR, FAINT = 100.0, -100.0


PLACE, WIDTH = remember(LEADER, (320, 240), PARAMETERS), WidthPrior(math.log(30.0), 0.0, 60.0)


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
    is_clear = is_new_clear(hypotheses, belief.width_prior, PARAMETERS, 320)
    belief = replace(belief, hypotheses=hypotheses, is_clear=is_clear)
    return belief_summary(belief, PARAMETERS, 320)


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
    np.testing.assert_array_equal(found.mean, LEADER)
    assert found.hypotheses[0].state.distance == LEADER[0]


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
def test_what_is_not_clear_is_claimed_where_the_cable_was_and_as_wide(leader, seconds, claim):
    found = summary(
        clearness=FAINT,
        leader=leader.to_array(),
        memory=PLACE.aged(seconds),
        width_prior=WIDTH.aged(seconds),
    )
    assert found.supports_claim == found.supports_keeping == claim
    assert not found.supports_new_claim


@given(st.floats(8.0, 200.0), st.floats(0.0, 100.0))
def test_a_first_claim_of_another_width_needs_more_the_sooner_the_more(width, seconds):
    hypotheses = initial_belief(CableState(0.0, 0.0, width).to_array()[None], 0.9).hypotheses
    needed = needed_clearness(width, PARAMETERS, 320)

    def is_clear(factor, prior):
        clear = hypotheses._replace(
            scaled_clearness=factor * needed, appearance=ORDINARY_APPEARANCE
        )
        return is_new_clear(clear, prior, PARAMETERS, 320)

    prior = WIDTH.aged(seconds)
    factor = 1.0 + prior.deviation(width, PARAMETERS) ** 2
    assert is_clear(1.001, None) and not is_clear(0.999, None)
    assert is_clear(1.001 * factor, prior) and not is_clear(0.999 * factor, prior)
    assert is_clear(1.001 * factor, prior.aged(10.0))


@given(st.sampled_from([8.0, 30.0, 150.0]), st.floats(-20.0, 20.0), st.booleans())
def test_a_strip_is_claimed_that_is_clear_by_its_borders_or_by_the_map(width, looks, is_mapped):
    leader = CableState(10.0, 0.2, width).to_array()
    hypotheses = initial_belief(leader[None], 0.9).hypotheses
    hypotheses = hypotheses._replace(appearance=looks, is_mapped=is_mapped)
    by_borders = needed_clearness(width, PARAMETERS, 320)
    by_borders -= clearness_by_borders(hypotheses, PARAMETERS, 320)
    by_map = PARAMETERS.evidence_to_find - clearness_by_map(hypotheses)
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
        return clearness_by_borders(looked_at, PARAMETERS, 320), clearness_by_map(looked_at)

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
    if clearness_by_map(hypotheses) >= PARAMETERS.evidence_to_find:
        assert mapped >= PARAMETERS.evidence_to_find


def test_a_thin_strip_that_looks_like_a_cable_needs_less_with_a_map():
    leader = CableState(10.0, 0.2, 8.0).to_array()
    looks = initial_belief(leader[None], 0.9).hypotheses._replace(
        appearance=ORDINARY_APPEARANCE, scaled_clearness=PARAMETERS.evidence_to_find
    )
    assert is_new_clear(looks._replace(is_mapped=True), None, PARAMETERS, 320)
    assert not is_new_clear(looks, None, PARAMETERS, 320)
