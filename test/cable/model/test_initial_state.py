from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.initial_state import (
    GivenPoint,
    GivenState,
    between,
    draw_given_states,
    random_states,
    search_box,
    usual_sigma,
)
from cable_tracker.cable.model.limits import possible_limits, state_limits
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import FrameError

COUNT = 20_000
DEGREE = np.pi / 180
KNOWN = CableState(20.0, 0.3, 40.0, 0.02, 5.0, 0.1, 2.0, -0.05)


def parameters(**changes) -> TrackerParameters:
    return preset("thesis").replaced({"particle_count": COUNT, **changes})


@pytest.mark.parametrize("width", [320, 640])
def test_a_random_start_fills_exactly_the_ranges_of_table_5_2(width, rng):
    scale = width / 320
    states = random_states(parameters(), width, rng)
    assert states.shape == (COUNT, 8)
    # Rates are per frame in the table and per second here.
    half = np.array([150 * scale, 45 * DEGREE, 47.5 * scale, 5 * DEGREE, 25 * scale, 2.5 * DEGREE])
    middle = np.array([0, 0, 52.5 * scale, 5 * DEGREE, 0, 0])
    assert (states[:, 6:] == 0.0).all()
    states = states[:, :6]
    assert (np.abs(states - middle) <= half * (1 + 1e-12)).all()
    # A uniform distribution: mean and variance to five standard errors.
    assert (np.abs(states.mean(axis=0) - middle) < 5 * half / np.sqrt(3 * COUNT)).all()
    np.testing.assert_allclose(states.var(axis=0), half**2 / 3, rtol=0.04)


NARROW = {
    "skew": {"skew_limit": 0.0},
    "width": {"width_minimum": 30.0, "width_maximum": 30.0},
    "narrower than the search": {"width_maximum": 4.5},
    "wider than the search": {"width_minimum": 120.0},
}


@pytest.mark.parametrize("limits", NARROW.values(), ids=NARROW)
def test_a_random_start_stays_within_the_limits(limits, rng):
    changed = parameters(initial_distance_range=1e4, **limits)
    states = random_states(changed, 320, rng)
    box = state_limits(changed, 320)
    assert (states[:, :4] >= box.lower).all()
    assert (states[:, :4] <= box.upper).all()
    # What lies beyond a limit is not searched: nothing piles up there.
    assert states[:, 0].std() == pytest.approx(box.upper[0] / np.sqrt(3.0), rel=0.03)


@pytest.mark.parametrize("limits", NARROW.values(), ids=NARROW)
def test_the_search_box_lies_within_the_possible_limits(limits):
    changed = parameters(**limits)
    box, possible = search_box(changed, 640), possible_limits(changed, 640)
    assert (possible.lower <= box.lower[:4]).all()
    assert (box.lower[:4] < box.upper[:4]).all()
    assert (box.upper[:4] <= possible.upper).all()


def test_a_given_state_is_the_middle_of_a_narrow_cloud(rng):
    moving = parameters(width_rate_variance=1.0, skew_rate_variance=0.1)
    states = draw_given_states(GivenState.around(KNOWN), moving, 320, rng)
    sigma = usual_sigma(320)
    error = np.abs(states.mean(axis=0) - KNOWN.to_array())
    assert (error < 5 * sigma / np.sqrt(COUNT)).all()
    np.testing.assert_allclose(states.std(axis=0), sigma, rtol=0.03)
    np.testing.assert_allclose(sigma[:4], [2.0, 0.5 * DEGREE, 2.0, 0.5 * DEGREE])


def test_a_model_whose_width_and_skew_have_no_rates_is_given_none(rng):
    still = CableState(20.0, 0.3, 40.0, 0.02, 5.0, 0.1)
    states = draw_given_states(GivenState.around(still), preset("thesis"), 320, rng)
    assert (states[:, 6:] == 0.0).all()
    assert (states[:, :6].std(axis=0) > 0.0).all()


def test_sigmas_that_are_given_are_used(rng):
    sigma = np.array([5.0, 0.01, 1.0, 0.001, 2.0, 0.5, 3.0, 0.1])
    states = draw_given_states(GivenState(KNOWN, sigma), parameters(), 320, rng)
    np.testing.assert_allclose(states.std(axis=0), sigma, rtol=0.03)


def test_a_sigma_of_zero_is_exact(rng):
    states = draw_given_states(GivenState(KNOWN, np.zeros(8)), parameters(), 320, rng)
    np.testing.assert_allclose(states, np.tile(KNOWN.to_array(), (COUNT, 1)))


def test_unknown_components_of_a_given_state_are_drawn_as_in_a_random_start(rng):
    sigma = np.array([1.0, 0.01, *[np.inf] * 6])
    states = draw_given_states(
        GivenState(CableState(20.0, 0.3, 0.0), sigma), parameters(), 320, rng
    )
    np.testing.assert_allclose(states.std(axis=0)[:2], sigma[:2], rtol=0.03)
    assert states[:, 2].min() == pytest.approx(5.0, abs=0.1)
    assert states[:, 2].max() == pytest.approx(100.0, abs=0.1)


def test_a_state_beside_the_wrap_becomes_one_cloud_on_both_sides(rng):
    lying = GivenState.around(CableState(10.0, np.pi / 2, 40.0))
    states = draw_given_states(lying, parameters(), 320, rng)
    upper = states[:, 1] > 0
    assert 0.4 < upper.mean() < 0.6
    assert (np.sign(states[:, 0]) == np.where(upper, 1, -1)).all()


def test_a_state_beyond_the_limits_is_brought_inside(rng):
    far = GivenState.around(CableState(1e6, 0.0, 1e6, 3.0))
    states = draw_given_states(far, parameters(), 320, rng)
    box = state_limits(parameters(), 320)
    np.testing.assert_allclose(states[:, [0, 2, 3]], np.tile(box.upper[[0, 2, 3]], (COUNT, 1)))


def only_distance(distance, sigma):
    """What is given of a cable of which only d is known, and that with a doubt."""
    return GivenState(CableState(distance, 0.3, 40.0), np.array([sigma, *[np.inf] * 7]))


@pytest.mark.parametrize("mean", [0.0, 60.0])
def test_a_distance_of_which_hardly_anything_is_known_piles_nothing_up_at_the_limit(mean, rng):
    distances = draw_given_states(only_distance(mean, 700.0), parameters(), 320, rng)[:, 0]
    limit = state_limits(parameters(), 320).upper[0]
    assert np.mean(np.abs(distances) == limit) < 0.01
    assert distances.std() == pytest.approx(150.0 / np.sqrt(3.0), rel=0.2)


def test_a_distance_that_is_known_well_beside_the_limit_stays_there(rng):
    limit = state_limits(parameters(), 320).upper[0]
    distances = draw_given_states(only_distance(limit - 1.0, 2.0), parameters(), 320, rng)[:, 0]
    assert np.mean(distances > limit - 10.0) > 0.99


@pytest.mark.parametrize(("sigma", "usual"), [(0.0, 0.0), (5.0, 5.0), (np.nan, 2.0)])
def test_cables_of_any_direction_pass_a_point_that_is_given(sigma, usual, rng):
    given = GivenState(
        CableState(0.0, 0.0, 0.0), np.full(8, np.inf), point=GivenPoint(20, 90, sigma)
    )
    states = draw_given_states(given, parameters(), 320, rng)
    misses = 20 * np.cos(states[:, 1]) + 90 * np.sin(states[:, 1]) - states[:, 0]
    assert np.sqrt(np.mean(misses**2)) == pytest.approx(usual, rel=0.03, abs=1e-9)
    assert np.abs(states[:, 1]).max() == pytest.approx(45 * DEGREE, rel=0.01)


def test_a_point_is_acceptable_that_is_finite_and_has_no_negative_doubt():
    def given(*point):
        return GivenState(KNOWN, np.full(8, np.inf), point=GivenPoint(*point))

    assert given(1.0, 2.0, np.nan).is_acceptable
    assert not given(np.nan, 2.0, 1.0).is_acceptable
    assert not given(1.0, np.inf, 1.0).is_acceptable
    assert not given(1.0, 2.0, -1.0).is_acceptable


def test_numbers_from_0_to_1_are_poses_from_one_corner_of_the_box_to_the_other():
    box = search_box(parameters(), 320)
    uniform = np.array([0.0, 0.5, 1.0])[:, None] * np.ones(8)
    np.testing.assert_allclose(
        between(box.lower, box.upper, uniform),
        [box.lower, (box.lower + box.upper) / 2, box.upper],
        atol=1e-12,
    )
    again = np.random.default_rng(1).random((5, 8))
    np.testing.assert_array_equal(
        between(box.lower, box.upper, again), box.draw(5, np.random.default_rng(1))
    )


def test_a_range_of_zero_is_a_narrow_box_and_no_division_by_zero():
    point = search_box(parameters(initial_distance_range=0.0, initial_angle_range=0.0), 320)
    assert (point.upper[:4] > point.lower[:4]).all()


def test_a_state_is_certain_when_all_of_it_is_given_and_it_is_no_guess():
    assert GivenState.around(KNOWN).is_certain
    assert not GivenState.around(KNOWN, is_guess=True).is_certain
    sigma = np.zeros(8)
    sigma[2] = np.inf
    assert not GivenState(KNOWN, sigma).is_certain
    sigma = np.zeros(8)
    sigma[4:] = np.inf
    assert GivenState(KNOWN, sigma).is_certain


@pytest.mark.parametrize(
    "sigma",
    [np.full(4, 2.0), [2.0, 0.01, 2.0, 0.01], np.full((8, 1), 2.0), 2.0, None, ["wide"] * 8],
    ids=str,
)
def test_sigmas_that_are_not_eight_are_refused_with_what_is_needed(sigma):
    with pytest.raises(FrameError, match="eight standard deviations"):
        GivenState(KNOWN, sigma)


def test_a_list_of_sigmas_is_as_good_as_an_array():
    sigma = [2.0, 0.01, np.nan, np.inf, 1, 1, 1, 1]
    np.testing.assert_array_equal(GivenState(KNOWN, sigma).sigma, np.array(sigma))


@pytest.mark.parametrize("huge", [1e100, 1e155, 1e300])
def test_a_huge_sigma_means_an_unknown_component(huge, rng):
    given = GivenState(KNOWN, np.full(8, huge))
    assert np.isinf(given.sigma).all()
    assert not given.is_certain
    states = draw_given_states(given, parameters(), 320, rng)
    assert np.isfinite(np.cov(states.T)).all()
