from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.predict.predicted_density import LEAST_PROBABILITY
from cable_tracker.cable.hypotheses.propose.frame_inputs import (
    FIRST_POWER,
    LOST_DETECTOR_SHARE,
    annealing_power,
    beside_a_known_cable,
    frame_config,
    refined_counts,
    sample_counts,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters

NO_ROUNDS = np.zeros(0, np.int64)
MASSES = st.floats(LEAST_PROBABILITY, 0.5)


def test_beside_a_known_cable_other_strips_count_less_and_the_map_where_it_shows_more():
    parameters = TrackerParameters()
    search = frame_config(parameters, 4.0, (320, 240))
    known = beside_a_known_cable(search, parameters)
    assert known.is_known and not search.is_known
    assert known.map_weights.overlap < search.map_weights.overlap
    assert sum(known.map_weights) == search.map_weights.overlap
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


def counts_of(count, survived, born, detections, refined=NO_ROUNDS):
    parameters = TrackerParameters(particle_count=count)
    return sample_counts(parameters, density_of(survived, born), detections, refined)


def density_of(survived, born):
    """Return what is read of a predicted density, half of its births about a remembered cable."""
    births = SimpleNamespace(share=0.5)
    return SimpleNamespace(mass_survived=survived, mass_born=born, births=births)


@given(
    st.integers(10, 5000), MASSES, MASSES, st.integers(0, 8),
    st.floats(0.0, 0.6),
)  # fmt: skip
def test_every_particle_is_drawn_from_something(count, survived, born, detections, refined):
    rounds = np.array([int(0.4 * refined * count), int(0.6 * refined * count)], np.int64)
    counts = counts_of(count, survived, born, detections, rounds)
    parts = (counts.survivors, counts.births, counts.switches, counts.detections)
    assert sum(parts) + rounds.sum() == count
    assert min(parts) >= 0
    assert counts.births_about_memory <= counts.births


@pytest.mark.parametrize("existing", [0.01, 0.99], ids=["searching", "tracked"])
@pytest.mark.parametrize(
    "shares",
    [(0.1, 0.0, 0.8), (0.04, 0.0, 0.86), (0.9, 0.0, 0.0), (0.0, 0.0, 0.9), (0.1, 0.5, 0.7)],
)
def test_whatever_shares_are_accepted_leave_particles_to_follow_a_cable_or_search_one(
    shares, existing
):
    names = ("detector_share", "search_share", "refinement_share")
    parameters = TrackerParameters(particle_count=500, **dict(zip(names, shares, strict=True)))
    counts = sample_counts(
        parameters, density_of(existing, LEAST_PROBABILITY), 3, refined_counts(parameters)
    )
    assert counts.survivors + counts.births >= 20
    if existing > 0.5:
        assert counts.survivors >= 20


def test_detections_get_more_particles_while_there_is_more_likely_no_cable():
    lost, held = counts_of(500, 0.1, 0.1, 3), counts_of(500, 0.9, 0.05, 3)
    assert lost.detections >= int(500 * LOST_DETECTOR_SHARE) > held.detections
    assert counts_of(500, 0.1, 0.1, 0).detections == 0
