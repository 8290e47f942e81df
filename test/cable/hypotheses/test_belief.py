from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.belief import initial_belief, resampled_belief
from cable_tracker.cable.hypotheses.weigh.clusters import NO_CLUSTER, Clusters


def test_states_that_are_given_count_alike_and_are_wrapped(rng):
    states = np.array([20.0, np.pi / 2, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0]) + rng.normal(
        0.0, 0.01, (50, 8)
    )
    belief = initial_belief(states, 0.9)
    assert belief.presence == 0.9
    np.testing.assert_allclose(belief.particles.weights, 1 / 50)
    assert (np.abs(belief.particles.states[:, 1]) <= np.pi / 2).all()
    # One cloud on both sides of the wrap: its middle is not upright.
    assert len(belief.hypotheses.clusters.masses) == 1
    assert abs(belief.hypotheses.clusters.means[0, 1]) == pytest.approx(np.pi / 2, abs=0.01)
    assert belief.memory is None


@pytest.mark.parametrize(
    ("known_time", "is_given", "known_after", "is_known"),
    [
        (0.0, False, 1.0, False),
        (1.0, False, 1.0, True),
        (0.0, True, 1e6, True),
        (0.04, False, 0.0, True),
        (0.0, False, 0.0, False),
    ],
)
def test_only_what_was_given_or_held_for_a_cable_is_known(
    known_time, is_given, known_after, is_known, rng
):
    belief = initial_belief(rng.normal(0.0, 0.1, (5, 8)), 0.9)
    belief = replace(belief, known_time=known_time, is_given=is_given)
    assert belief.is_known(known_after) == is_known
    assert belief.is_followed == (is_given or known_time > 0.0)


def test_a_belief_that_is_resampled_keeps_its_hypotheses(rng):
    belief = initial_belief(rng.normal(0.0, 0.1, (50, 8)), 0.9)
    labels = np.repeat([0, 1, NO_CLUSTER], [30, 15, 5])
    means = rng.normal(0.0, 1.0, (2, 8))
    clusters = Clusters(labels, np.array([0.6, 0.3]), means, np.arange(2), 0.1)
    hypotheses = belief.hypotheses._replace(clusters=clusters)
    belief = replace(belief, hypotheses=hypotheses, log_odds=np.array([2.0, -1.0]))
    drawn = resampled_belief(belief, np.array([0, 29, 29, 44, 49]))
    after = drawn.hypotheses.clusters
    assert after.labels.tolist() == [0, 0, 0, 1, NO_CLUSTER]
    assert after.masses.tolist() == [0.6, 0.2]
    assert after.rest == 0.2
    assert after.means is means
    assert drawn.hypotheses.effective_size == 5.0
    assert drawn.log_odds is belief.log_odds
    np.testing.assert_array_equal(drawn.particles.states[3], belief.particles.states[44])
    np.testing.assert_allclose(drawn.particles.weights, 0.2)
