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
    MOST_APPEARANCE,
    belief_summary,
    is_new_clear,
)
from cable_tracker.cable.hypotheses.evidence_correction import ORDINARY_APPEARANCE
from cable_tracker.cable.hypotheses.remembered_cable import remember
from cable_tracker.cable.hypotheses.thin_strips import needed_clearness, trusted_share
from cable_tracker.cable.hypotheses.width_prior import WidthPrior
from cable_tracker.cable.measure.border_points import MINIMUM_POINTS
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters()
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
CLEAR, FAINT = 100.0, -100.0


PLACE, WIDTH = remember(LEADER, (320, 240), PARAMETERS), WidthPrior(math.log(30.0), 0.0, 60.0)


def summary(
    presence=0.99, border_mean=CLEAR, clearness=CLEAR, length=MINIMUM_POINTS, leader=LEADER, **known
):
    belief = replace(initial_belief(leader[None], presence), **known)
    hypotheses = belief.hypotheses._replace(
        covariance=np.eye(8),
        weaker_border_mean=border_mean,
        scaled_clearness=clearness,
        appearance=ORDINARY_APPEARANCE,
        visible_length=length,
    )
    return belief_summary(replace(belief, hypotheses=hypotheses), PARAMETERS, 320)


@pytest.mark.parametrize(
    ("changes", "claim", "new_claim", "keeping"),
    [
        ({}, True, True, True),
        ({"clearness": FAINT, "known_time": 0.04}, True, False, True),
        ({"clearness": FAINT}, False, False, False),
        ({"border_mean": FAINT}, False, False, False),
        ({"presence": 0.01}, False, False, False),
        ({"length": MINIMUM_POINTS - 0.1}, False, False, False),
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
        ordinary = ORDINARY_APPEARANCE * trusted_share(width, PARAMETERS.thin_width)
        clear = hypotheses._replace(scaled_clearness=factor * needed, appearance=ordinary)
        return is_new_clear(clear, prior, PARAMETERS, 320)

    prior = WIDTH.aged(seconds)
    factor = 1.0 + prior.deviation(width, PARAMETERS) ** 2
    assert is_clear(1.001, None) and not is_clear(0.999, None)
    assert is_clear(1.001 * factor, prior) and not is_clear(0.999 * factor, prior)
    assert is_clear(1.001 * factor, prior.aged(10.0))


@pytest.mark.parametrize(
    ("more", "worth"),
    [(1.0, 1.0), (100.0, MOST_APPEARANCE), (-100.0, LEAST_APPEARANCE)],
)
def test_the_looks_of_a_strip_are_worth_clearness_up_to_a_limit(more, worth):
    hypotheses = initial_belief(LEADER[None], 0.9).hypotheses
    needed = needed_clearness(LEADER[2], PARAMETERS, 320) - APPEARANCE_SHARE * worth

    def is_clear(clearness):
        looked_at = hypotheses._replace(
            scaled_clearness=clearness, appearance=ORDINARY_APPEARANCE + more
        )
        return is_new_clear(looked_at, None, PARAMETERS, 320)

    assert is_clear(needed + 1e-6) and not is_clear(needed - 1e-6)
