from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.belief import initial_belief
from cable_tracker.cable.hypotheses.claim_support import belief_summary
from cable_tracker.cable.measure.border_points import MINIMUM_POINTS
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters()
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
CLEAR, FAINT = 100.0, -100.0


def summary(presence=0.99, border_mean=CLEAR, clearness=CLEAR, length=MINIMUM_POINTS):
    belief = initial_belief(LEADER[None], presence)
    hypotheses = belief.hypotheses._replace(
        covariance=np.eye(8),
        weaker_border_mean=border_mean,
        scaled_clearness=clearness,
        visible_length=length,
    )
    return belief_summary(replace(belief, hypotheses=hypotheses), PARAMETERS, 320)


@pytest.mark.parametrize(
    ("changes", "claim", "new_claim", "keeping"),
    [
        ({}, True, True, True),
        ({"clearness": FAINT}, True, False, True),
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
