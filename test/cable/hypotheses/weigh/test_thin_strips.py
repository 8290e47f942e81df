from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.weigh.thin_strips import (
    LEAST_FACTOR,
    MOST_FACTOR,
    USUAL_WIDTH,
    needed_clearness,
    thin_factor,
    trusted_appearance,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters

PARAMETERS = TrackerParameters()
USUAL = USUAL_WIDTH * PARAMETERS.thin_width


def test_a_cable_of_the_usual_width_needs_what_the_parameter_says():
    assert needed_clearness(USUAL, PARAMETERS, 320) == PARAMETERS.evidence_to_find
    assert needed_clearness(2 * USUAL, PARAMETERS, 640) == PARAMETERS.evidence_to_find


def test_one_half_as_wide_needs_twice_as_much():
    needed = needed_clearness(USUAL / 2, PARAMETERS, 320)
    assert needed == pytest.approx(2 * PARAMETERS.evidence_to_find)


@given(st.floats(0.0, 1e4), st.floats(0.0, 1e4))
def test_a_wider_one_never_needs_more_and_there_are_limits(width, other):
    needed = [needed_clearness(each, PARAMETERS, 320) for each in sorted((width, other))]
    assert needed[0] >= needed[1]
    least, most = LEAST_FACTOR, MOST_FACTOR
    for each in needed:
        assert least <= each / PARAMETERS.evidence_to_find * (1 + 1e-9)
        assert each / PARAMETERS.evidence_to_find <= most * (1 + 1e-9)


@pytest.mark.parametrize("evidence", [0.0, -1.0])
def test_who_asks_for_nothing_gets_any_width(evidence):
    parameters = TrackerParameters(evidence_to_find=evidence)
    assert needed_clearness(4.0, parameters, 320) == evidence


def test_thin_strips_count_less_but_something():
    factors = [thin_factor(width, 12.0) for width in (0.0, 3.0, 6.0, 12.0, 100.0)]
    assert factors == pytest.approx([0.5, 0.5, math.sqrt(0.5), 1.0, 1.0])


@given(st.floats(0.1, 500.0), st.floats(-20.0, 20.0))
def test_looks_speak_for_wide_strips_alone_and_against_all(width, appearance):
    trusted = trusted_appearance(appearance, width, 12.0)
    assert min(appearance, 0.0) - 1e-9 <= trusted <= max(appearance, 0.0) + 1e-9
    if width >= 24.0 or appearance <= 0.0:
        assert trusted == pytest.approx(appearance)
    elif width <= 16.0:
        assert trusted == 0.0
