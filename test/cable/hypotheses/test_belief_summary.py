from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.belief import initial_belief
from cable_tracker.cable.hypotheses.belief_summary import belief_summary
from cable_tracker.cable.hypotheses.clearness import is_new_clear
from cable_tracker.cable.hypotheses.evidence_correction import ORDINARY_APPEARANCE
from cable_tracker.cable.hypotheses.remembered_cable import remember
from cable_tracker.cable.measure.border_points import MINIMUM_LENGTH
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters()
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
CLEAR, FAINT = 100.0, -100.0
MEMORY = replace(remember(None, LEADER, (320, 240), 0.0, PARAMETERS), tracked_time=60.0)


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
    is_clear = is_new_clear(hypotheses, belief.memory, PARAMETERS, 320)
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
        memory=MEMORY.aged(seconds),
    )
    assert found.supports_claim == found.supports_keeping == claim
    assert not found.supports_new_claim
