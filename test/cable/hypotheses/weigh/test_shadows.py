from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.weigh.association import SAME_HYPOTHESIS_RADII
from cable_tracker.cable.hypotheses.weigh.shadows import (
    LEAST_RATIO,
    ShadowRules,
    empty_shadows,
    fill_shadow_losses,
    find_shadows,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.borders.polarity_prior import BRIGHT, DARK
from cable_tracker.cable.measure.picture.working_image import make_working_image
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

SIZE = (320, 240)
PARAMETERS = TrackerParameters()
RATIO = BorderLikelihoodRatio(PARAMETERS)
RULES = ShadowRules(
    PARAMETERS.shadow_evidence, PARAMETERS.evidence_limit, SAME_HYPOTHESIS_RADII, 1.0
)

CABLE = CableState(-20.0, 0.2, 40.0, 0.0)
SHADOW = CableState(15.0, 0.2, 30.0, 0.0)
ELSEWHERE = CableState(80.0, 0.2, 30.0, 0.0)
GROUND, BRIGHTER, DARKER = 110.0, 150.0, 70.0


@pytest.fixture
def picture(draw_strip):
    """Grey levels of strips on a bottom with some grain."""

    def draw(*strips):
        levels = np.random.default_rng(2).normal(GROUND, 4.0, SIZE[::-1])
        for state, level in strips:
            inside = draw_strip(state, SIZE, strip=255.0, ground=0.0) / 255.0
            levels += inside * (level - GROUND)
        return np.clip(levels, 0.0, 255.0).astype(np.uint8)

    return draw


def rows(*states):
    return np.array([state.to_array() for state in states])


def judged(image, states, rules=RULES, possible=None, mapped=None):
    """Return the number of shadows, what each strip loses, and its ratios.

    `mapped`: what a map says of each strip [nats]; None: nothing.
    """
    found = RATIO.measure(states, make_working_image(image, SIZE[0]))
    shadows, losses = empty_shadows(), np.full(len(states), np.nan)
    if possible is None:
        possible = np.ones(len(states), bool)
    mapped = np.zeros(len(states)) if mapped is None else np.array(mapped)
    count = find_shadows(states, possible, found, mapped, rules, shadows)
    fill_shadow_losses(states, found, shadows, count, rules.unit, losses)
    return count, losses, found.log_ratios


def test_a_dark_strip_beside_a_bright_cable_is_less_likely_than_the_cable(picture):
    states = rows(CABLE, SHADOW)
    count, losses, ratios = judged(picture((CABLE, BRIGHTER), (SHADOW, DARKER)), states)
    assert count == 1
    assert losses[0] == 0.0
    assert ratios[1, DARK] - losses[1] < min(ratios[0, BRIGHT], RULES.limit)


def test_the_shadow_may_lie_on_either_side(picture):
    left = CableState(-55.0, 0.2, 30.0, 0.0)
    image = picture((CABLE, BRIGHTER), (left, DARKER))
    count, losses, _ = judged(image, rows(CABLE, left))
    assert count == 1
    assert losses[1] > 0.0


def test_what_lies_in_a_shadow_is_one_too_and_what_lies_elsewhere_is_none(picture):
    part = CableState(17.0, 0.22, 24.0, 0.0)
    image = picture((CABLE, BRIGHTER), (SHADOW, DARKER), (ELSEWHERE, DARKER))
    _, losses, ratios = judged(image, rows(CABLE, SHADOW, part, ELSEWHERE))
    assert ratios[2, DARK] - losses[2] <= ratios[1, DARK] - losses[1] + 1e-9
    assert ratios[3, DARK] > RULES.limit
    assert losses[3] == 0.0


def test_the_gap_between_two_dark_strips_casts_no_shadow(picture):
    other = CableState(-55.0, 0.2, 30.0, 0.0)
    image = picture((other, DARKER), (SHADOW, DARKER))
    count, losses, ratios = judged(image, rows(CABLE, other, SHADOW))
    assert ratios[0, BRIGHT] > RULES.limit
    assert count == 0
    assert (losses == 0.0).all()


def test_a_dark_cable_at_the_edge_of_a_bright_field_is_no_shadow(picture):
    field = CableState(-150.0, 0.2, 300.0, 0.0)
    count, _, ratios = judged(picture((field, BRIGHTER), (SHADOW, DARKER)), rows(CABLE, SHADOW))
    assert ratios[1, DARK] > RULES.limit
    assert count == 0


def test_a_dark_cable_that_the_picture_cuts_off_is_no_shadow(picture):
    beyond = CableState(120.0, 0.0, 120.0, 0.0)
    beside = CableState(40.0, 0.0, 40.0, 0.0)
    states = rows(beside, beyond)
    image = picture((beside, BRIGHTER), (beyond, DARKER))
    count, _, ratios = judged(image, states)
    assert ratios[1, DARK] > LEAST_RATIO
    assert count == 0


def test_what_the_map_shows_instead_of_the_bright_strip_loses_nothing(picture):
    image, states = picture((CABLE, BRIGHTER), (SHADOW, DARKER)), rows(CABLE, SHADOW)
    _, losses, _ = judged(image, states, mapped=[-40.0, 30.0])
    assert (losses == 0.0).all()


def test_a_map_that_shows_the_bright_strip_or_both_spares_no_shadow(picture):
    image, states = picture((CABLE, BRIGHTER), (SHADOW, DARKER)), rows(CABLE, SHADOW)
    _, unmapped, _ = judged(image, states)
    for mapped in ([30.0, -40.0], [8.0, 8.0]):
        _, losses, _ = judged(image, states, mapped=mapped)
        np.testing.assert_array_equal(losses, unmapped)


def test_nothing_is_a_shadow_where_no_evidence_is_enough(picture):
    image = picture((CABLE, BRIGHTER), (SHADOW, DARKER))
    count, _, _ = judged(image, rows(CABLE, SHADOW), RULES._replace(evidence=np.inf))
    assert count == 0


def test_impossible_particles_cast_no_shadow(picture):
    image = picture((CABLE, BRIGHTER), (SHADOW, DARKER))
    for row in range(2):
        possible = np.arange(2) != row
        assert judged(image, rows(CABLE, SHADOW), possible=possible)[0] == 0


@given(turned=st.lists(st.booleans(), min_size=3, max_size=3))
def test_half_turns_change_nothing(turned):
    rng = np.random.default_rng(4)
    states = rows(CABLE, SHADOW, CableState(16.0, 0.21, 25.0, 0.01))
    other = states.copy()
    for row in np.flatnonzero(turned):
        other[row, [0, 3]] *= -1.0
        other[row, 1] += np.pi
    # The same log-ratios: the sides of a strip that is turned round change places.
    found = RATIO.measure(
        states, make_working_image(rng.integers(0, 255, SIZE[::-1], np.uint8), SIZE[0])
    )
    found.log_ratios[:] = [[30.0, -9.0], [-9.0, 35.0], [-9.0, 25.0]]
    found.bright_border_log_ratios[:] = 15.0
    found.outsides[:] = [[9.0, 5.0], [14.0, 9.0], [9.0, 9.0]]
    swapped = found._replace(outsides=found.outsides.copy())
    for row in np.flatnonzero(turned):
        swapped.outsides[row] = found.outsides[row, ::-1]
    both = []
    for each, said in ((states, found), (other, swapped)):
        shadows, losses = empty_shadows(), np.zeros(3)
        count = find_shadows(each, np.ones(3, bool), said, np.zeros(3), RULES, shadows)
        fill_shadow_losses(each, said, shadows, count, 1.0, losses)
        both.append((count, losses))
    assert both[0][0] == both[1][0] == 1
    np.testing.assert_allclose(both[0][1], both[1][1], atol=1e-9)
    assert both[0][1][1] > 0.0
