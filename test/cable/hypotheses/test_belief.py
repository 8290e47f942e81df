from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.belief import (
    Belief,
    RememberedCable,
    initial_belief,
    remember,
    resampled_belief,
)
from cable_tracker.cable.hypotheses.claim import (
    CRISP,
    POLARITY_DOUBT,
    updated_belief,
    updated_p_bright,
)
from cable_tracker.cable.hypotheses.clusters import NO_CLUSTER, Clusters
from cable_tracker.cable.hypotheses.conclusion import Conclusion
from cable_tracker.cable.hypotheses.predicted_density import width_penalty
from cable_tracker.cable.measure.map.cable_map import NO_KEPT_MAP, NO_MAP, KeptMap, MapBorders
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import probability_of

PARAMETERS = TrackerParameters()
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
YOUNG = 0.5 * PARAMETERS.known_after
BEFORE = replace(initial_belief(LEADER[None], 0.9), known_time=YOUNG, faint_time=0.3)
CLEAR, FAINT = 100.0, -100.0
SHARES = st.floats(0.0, 1.0)

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


def test_what_was_given_stays_so_while_frames_hold_it_for_a_cable():
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


def test_what_is_lost_in_the_map_is_clear_only_if_a_frame_before_held_it_for_a_cable():
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


def test_a_frame_without_a_cable_says_nothing_of_its_polarity():
    assert updated_p_bright(0.8, 0.0, 0.0, 1.0, 0.04) == pytest.approx(0.8)
    assert updated_p_bright(0.8, 0.1, 1.0, 1.0, 0.04) == pytest.approx(0.1)


def test_what_was_known_is_forgotten_with_time():
    soon, late = (updated_p_bright(0.9, 0.9, 0.0, 0.9, dt) for dt in (0.04, 4.0))
    assert 0.5 < late < soon < 0.9


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


def test_it_says_less_the_longer_no_cable_is_seen():
    usual = as_wide_as(30.0)
    now, soon, late = (factors(replace(usual, seconds=s), [60.0])[0] for s in (0.0, 4.0, 4000.0))
    assert now < soon < late < 0.0
    assert late == pytest.approx(0.0, abs=1e-3)


def test_it_says_more_the_longer_a_cable_was_seen():
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
def test_it_is_time_that_counts_not_frames(first, second):
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
