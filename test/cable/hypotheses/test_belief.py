from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.belief import (
    RememberedCable,
    initial_belief,
    remember,
    resampled_belief,
)
from cable_tracker.cable.hypotheses.clusters import NO_CLUSTER, Clusters
from cable_tracker.cable.hypotheses.predicted_density import width_penalty
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters()

SIZE = (320, 240)
MEMORY_PARAMETERS = TrackerParameters(
    width_spread=0.3, width_time=2.0, width_memory=4.0, leaving_margin=8.0
)


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
        (0.0, True, 5.0, True),
        (0.04, False, 0.0, True),
        (0.0, False, 0.0, False),
    ],
)
def test_only_what_was_given_or_held_for_a_cable_is_known(
    known_time, is_given, known_after, is_known, rng
):
    belief = initial_belief(rng.normal(0.0, 0.1, (5, 8)), 0.9)
    belief = replace(belief, known_time=known_time, is_given=is_given)
    parameters = PARAMETERS.replaced({"known_after": known_after})
    assert belief.is_known(parameters) == is_known
    assert not replace(belief, faint_time=PARAMETERS.search_time).is_known(parameters)
    assert belief.is_followed == (is_given or known_time > 0.0)


def test_a_belief_that_is_resampled_keeps_its_hypotheses(rng):
    belief = initial_belief(rng.normal(0.0, 0.1, (50, 8)), 0.9)
    labels = np.repeat([0, 1, NO_CLUSTER], [30, 15, 5])
    means = rng.normal(0.0, 1.0, (2, 8))
    clusters = Clusters(labels, np.array([0.6, 0.3]), means, 0.1)
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


def cable(distance=20.0, width=30.0) -> np.ndarray:
    return np.array([distance, 0.0, width, 0.0, 0.0, 0.0, 0.0, 0.0])


def remembered(before=None, state=None, dt=0.04) -> RememberedCable:
    return remember(before, cable() if state is None else state, SIZE, dt, MEMORY_PARAMETERS, 1.0)


def as_wide_as(width) -> RememberedCable:
    return remembered(state=cable(width=width))


def factors(usual, widths) -> np.ndarray:
    spread = usual.width_spread(MEMORY_PARAMETERS)
    return np.array([width_penalty(width, usual.log_width, spread) for width in widths])


@given(st.floats(3.0, 200.0), st.floats(0.01, 2.0), st.floats(0.01, 1.0))
def test_the_usual_width_fits_best_and_others_the_worse_the_farther(width, far, farther):
    ratios = np.exp([0.0, far, far + farther, -far, -far - farther])
    values = factors(as_wide_as(width), width * ratios)
    assert values[0] == pytest.approx(0.0, abs=1e-9)
    assert values[0] > values[1] > values[2]
    # As much narrower is as bad as as much wider.
    np.testing.assert_allclose(values[3:], values[1:3], atol=1e-6)


def test_the_remembered_width_counts_less_the_longer_no_cable_is_seen():
    usual = as_wide_as(30.0)
    now, soon, late = (factors(replace(usual, seconds=s), [60.0])[0] for s in (0.0, 4.0, 4000.0))
    assert now < soon < late < 0.0
    assert late == pytest.approx(0.0, abs=1e-3)


def test_the_remembered_width_counts_more_the_longer_a_cable_was_seen():
    young, old = (replace(as_wide_as(30.0), tracked_time=s) for s in (0.0, 60.0))
    assert factors(old, [60.0])[0] < factors(young, [60.0])[0] < 0.0


def test_widths_of_nothing_and_less_are_bad_but_no_error():
    assert np.isfinite(factors(as_wide_as(30.0), [0.0, -5.0])).all()


def test_without_a_prior_any_width_will_do():
    assert width_penalty(7.0, 0.0, math.inf) == 0.0


def test_the_first_width_is_the_usual_one():
    assert remembered().log_width == math.log(30.0)
    assert remembered().tracked_time == 0.0


def test_the_mean_follows_within_its_time_and_is_seen_again():
    usual = replace(as_wide_as(30.0), seconds=3.0)
    for _ in range(50):
        usual = remembered(usual, cable(width=60.0))
    assert usual.seconds == 0.0
    assert usual.tracked_time == pytest.approx(2.0)
    assert usual.log_width - math.log(30.0) == pytest.approx((1 - math.exp(-1)) * math.log(2.0))


@given(st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_the_width_is_averaged_over_time_not_over_frames(first, second):
    usual = as_wide_as(30.0)
    wide = cable(width=60.0)
    twice = remembered(remembered(usual, wide, first), wide, second)
    once = remembered(usual, wide, first + second)
    assert twice.log_width == pytest.approx(once.log_width)


@pytest.mark.parametrize(("distance", "side"), [(150.0, 1.0), (-150.0, -1.0), (20.0, 0.0)])
def test_a_cable_at_the_edge_is_remembered_with_its_side(distance, side):
    memory = remembered(state=cable(distance))
    assert memory.side == side
    assert memory.inset == pytest.approx(160.0 - abs(distance))
    np.testing.assert_array_equal(memory.pose, cable(distance)[:4])
