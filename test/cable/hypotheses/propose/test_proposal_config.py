from __future__ import annotations

from cable_tracker.cable.hypotheses.propose.proposal_config import (
    beside_a_known_cable,
    proposal_config,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters


def test_beside_a_known_cable_other_strips_count_less_and_the_map_where_it_shows_more():
    parameters = TrackerParameters()
    search = proposal_config(parameters, 4.0, (320, 240))
    known = beside_a_known_cable(search, parameters)
    assert known.is_known and not search.is_known
    assert known.map_weights.overlap < search.map_weights.overlap
    assert sum(known.map_weights) == sum(search.map_weights)
    limits = (known.evidence_limits, search.evidence_limits)
    assert [each.evidence_limit for each in limits] == [
        parameters.evidence_limit_known,
        parameters.evidence_limit,
    ]
    changed = {"evidence_limits": None, "is_known": None, "map_weights": None}
    for before, after in zip(search._replace(**changed), known._replace(**changed), strict=True):
        assert before is after
