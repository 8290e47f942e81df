from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.predict.predicted_density import LEAST_PROBABILITY
from cable_tracker.cable.hypotheses.propose.frame_inputs import refined_counts
from cable_tracker.cable.hypotheses.propose.sample_counts import LOST_DETECTOR_SHARE, sample_counts
from cable_tracker.cable.parameters.parameters import TrackerParameters

NO_ROUNDS = np.zeros(0, np.int64)
MASSES = st.floats(LEAST_PROBABILITY, 0.5)


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
