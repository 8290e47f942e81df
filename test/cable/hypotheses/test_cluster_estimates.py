from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.belief import initial_belief
from cable_tracker.cable.hypotheses.cluster_estimates import (
    BLUR,
    BORDER_TURN,
    LEAST_WIDTH_SHARE,
    MAP_DOUBT,
    MOST_MAP_DOUBT,
    displaced_covariance,
    displacement_factors,
    leading_estimate,
    width_before_smoothing,
    width_by_map,
)
from cable_tracker.cable.measure.map.cable_map import AS_THE_STRIP, MapBorders
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset

PARAMETERS = TrackerParameters()
LEADER = CableState(10.0, 0.2, 30.0, 0.0).to_array()
CLEAR, FAINT = 100.0, -100.0


def displaced(left, right, covariance=None, width=80.0, **changes):
    """Return what is stated for two mean log-ratios, in frames of twice the reference width."""
    parameters = preset("default").replaced({"border_displacement": 1.0, **changes})
    before = np.zeros((8, 8)) if covariance is None else covariance
    return displaced_covariance(before, np.array([left, right]), width, parameters, 2.0)


def test_a_border_is_displaced_twice_as_far_for_each_step_of_less_evidence():
    factors = displacement_factors(np.array([2.3, 1.8, 1.55, 1.3, 0.0, -50.0]), 40.0)
    np.testing.assert_allclose(factors, [0.25, 1.0, 2.0, 4.0, 10.0, 10.0])


@pytest.mark.parametrize(("width", "most"), [(1.0, 4.0), (16.0, 4.0), (32.0, 8.0), (200.0, 12.0)])
def test_a_border_is_displaced_by_a_quarter_of_the_width_within_limits(width, most):
    np.testing.assert_allclose(displacement_factors(np.array([-1.0, 9.0]), width)[0], most)


def test_borders_that_are_alike_displace_no_component_with_another():
    covariance = displaced(1.8, 1.8)
    turn = BORDER_TURN**2
    # Each by 2 px of these frames; w by 2 px more, if the cable is round.
    np.testing.assert_allclose(np.diag(covariance)[:4], [2.0, turn / 2, 8.0 + 4.0, turn / 2])
    np.testing.assert_allclose(covariance, np.diag(np.diag(covariance)), atol=1e-15)
    assert not covariance[4:].any()


@pytest.mark.parametrize(("border_means", "side"), [((9.0, 0.0), 1.0), ((0.0, 9.0), -1.0)])
def test_the_displacement_of_one_lost_border_counts_half_in_d_and_fully_in_w(border_means, side):
    covariance = displaced(*border_means)
    sigmas = np.sqrt(np.diag(covariance)[:4])
    # A border lost by 20 of 80 px of these frames; the other one lies where it is seen.
    turn = 10.0 * BORDER_TURN
    np.testing.assert_allclose(sigmas, [10.0, turn / 2, np.hypot(20.0, 2.0), turn / 2], rtol=1e-6)
    correlations = covariance[[0, 1], [2, 3]] / (sigmas[:2] * sigmas[2:])
    np.testing.assert_allclose(correlations, [side, side], rtol=0.01)


def test_particles_count_as_wide_as_without_tempering_and_rates_as_they_are():
    rng = np.random.default_rng(0)
    root = rng.normal(size=(8, 8))
    before = root @ root.T
    after = displaced(1.8, 1.0, before, border_displacement=0.0, tempering=0.25)
    np.testing.assert_allclose(after[:4, :4], before[:4, :4] / 4)
    np.testing.assert_allclose(after[:4, 4:], before[:4, 4:] / 2)
    np.testing.assert_array_equal(after[4:, 4:], before[4:, 4:])
    np.testing.assert_array_equal(after, after.T)


def test_a_lost_border_leaves_a_covariance():
    values = np.linalg.eigvalsh(displaced(-3.0, 2.2, np.eye(8) * 1e-4))
    assert values.min() > 0.0


@given(width=st.floats(5.0, 40.0))
def test_the_width_is_about_that_of_the_strip_whose_smoothed_borders_are_steepest_there(width):
    parameters = preset("default")
    sigma = np.hypot(parameters.filter_sigma, BLUR)
    x = np.linspace(0.0, width, 20001)
    left, right = (np.exp(-0.5 * ((x + side * width / 2) / sigma) ** 2) for side in (1.0, -1.0))
    steepest = 2.0 * x[np.argmax(right - left)]
    assert width_before_smoothing(steepest, parameters, 1.0) == pytest.approx(width, rel=0.1)


@given(narrow=st.floats(0.0, 300.0), more=st.floats(0.01, 100.0))
def test_the_width_before_smoothing_grows_with_the_width_seen(narrow, more):
    widths = [
        width_before_smoothing(each, preset("default"), 1.0) for each in (narrow, narrow + more)
    ]
    assert widths[0] < widths[1]


@given(width=st.floats(0.0, 500.0))
def test_a_cable_thinner_than_the_smoothing_keeps_most_of_its_width(width):
    left = width_before_smoothing(width, preset("default"), 1.0)
    assert LEAST_WIDTH_SHARE * width <= left <= width


@pytest.mark.parametrize(("widening", "added"), [(0.4, 0.0), (-0.5, 0.0), (3.5, 2.01), (-3.5, 0.0)])
def test_two_thirds_of_a_widening_beyond_what_maps_resolve_are_believed(widening, added):
    assert width_by_map(widening, PARAMETERS, 1.0) == pytest.approx(added)
    assert width_by_map(2.0 * widening, PARAMETERS, 2.0) == pytest.approx(2.0 * added)
    assert width_by_map(widening, replace(PARAMETERS, map_width_share=0.0), 1.0) == 0.0


@pytest.mark.parametrize("parameters", [PARAMETERS, replace(PARAMETERS, map_width_share=0.0)])
def test_shadows_are_taken_off_the_borders_where_maps_have_a_say(parameters):
    belief = initial_belief(LEADER[None], 0.99)
    hypotheses = belief.hypotheses._replace(covariance=np.eye(8))
    seen, plain = (
        leading_estimate(hypotheses, shown, parameters, 1.0)
        for shown in (MapBorders(-9.0, 6.0, 2.0), AS_THE_STRIP)
    )
    share = float(parameters.map_width_share > 0.0)
    np.testing.assert_allclose(seen[0] - plain[0], share * np.array([2.0, 0, -8, 0, 0, 0, 0, 0]))
    # The left border is doubted three times as much as the right one: where d is too large, w is
    # too small.
    more = seen[1] - plain[1]
    assert more[0, 0] == pytest.approx(share * 0.25 * 0.4**2 * (6.0**2 + 2.0**2))
    assert more[2, 2] == pytest.approx(share * 0.4**2 * (6.0**2 + 2.0**2))
    assert more[0, 2] == pytest.approx(share * 0.5 * 0.4**2 * (2.0**2 - 6.0**2))


def leading_sigmas(**changes):
    hypotheses = initial_belief(LEADER[None], 0.99).hypotheses
    hypotheses = hypotheses._replace(covariance=np.eye(8), **changes)
    covariance = leading_estimate(hypotheses, AS_THE_STRIP, PARAMETERS, 1.0)[1]
    return np.sqrt(np.diag(covariance))


@pytest.mark.parametrize("overlap", [0.05, 0.6, 0.8, 0.9, 0.97])
def test_borders_are_the_less_sure_the_less_the_strip_overlaps_with_its_map(overlap):
    less, more = (
        leading_sigmas(is_mapped=True, overlap_share=share) for share in (overlap, overlap + 0.03)
    )
    assert (less[:3:2] >= more[:3:2]).all()
    added = np.sqrt(less**2 - leading_sigmas(is_mapped=False) ** 2)
    expected = min(MAP_DOUBT * (1.0 - overlap) / overlap, MOST_MAP_DOUBT) * LEADER[2]
    assert added[0] == pytest.approx(math.sqrt(0.5) * expected)
    assert added[2] == pytest.approx(math.sqrt(2.0) * expected)
    assert added[[1, 3]] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_a_strip_that_is_all_of_its_map_is_as_sure_as_its_borders():
    sure = leading_sigmas(is_mapped=True, overlap_share=1.0)
    assert sure == pytest.approx(leading_sigmas(is_mapped=False))
