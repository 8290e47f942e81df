from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cable_tracker.cable.model.limits import state_limits
from cable_tracker.cable.model.movement import (
    CableMovement,
    effective_time,
    gained_spread,
    variances_per_frame,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.movement import LimitedMovement

FRAME = 0.04
COUNT = 40_000
DEGREE = np.pi / 180
START = np.array([5.0, 0.1, 80.0, 0.0, 30.0, 0.2, 4.0, 0.1])
FREE = {"distance_limit": 1e4, "width_minimum": 0.5, "width_maximum": 1e4, "skew_limit": 80.0}
STILL = dict.fromkeys(
    (
        "distance_variance",
        "angle_variance",
        "width_variance",
        "skew_variance",
        "distance_rate_variance",
        "angle_rate_variance",
        "width_rate_variance",
        "skew_rate_variance",
    ),
    0.0,
)


def moved(parameters, dt, rng, states=None, width=320):
    states = np.tile(START, (COUNT, 1)) if states is None else states
    return LimitedMovement(parameters, width).propagate(states, dt, rng)


def thesis(**changes) -> TrackerParameters:
    return preset("thesis").replaced({**FREE, **changes})


TABLE_5_1 = np.array([0.5, 0.01 * DEGREE**2, 4.0, 0.1 * DEGREE**2])
RATES_OF_TABLE_5_1 = np.array([8.0 * 625, 0.005 * DEGREE**2 * 625, 0.0, 0.0])
SOME = TrackerParameters(
    distance_variance=2.0,
    angle_variance=0.1,
    width_variance=1.0,
    skew_variance=0.1,
    distance_rate_variance=3.0,
    angle_rate_variance=0.05,
    width_rate_variance=1.0,
    skew_rate_variance=0.02,
)


def spread_of(parameters, dt, width=320):
    return gained_spread(variances_per_frame(parameters, width), parameters.rate_damping, dt)


def variances_of(parameters, dt, width=320):
    return spread_of(parameters, dt, width)[0]


def variances(dt, damping=0.9):
    return variances_of(SOME.replaced({"rate_damping": damping}), dt)


def test_one_frame_adds_exactly_the_variances_of_the_thesis():
    # Table 5.1; its rates are per frame, ours per second.
    expected = np.concatenate((TABLE_5_1, RATES_OF_TABLE_5_1))
    np.testing.assert_allclose(variances_of(preset("thesis"), FRAME), expected)


@pytest.mark.parametrize("damping", [0.0, 0.5, 0.9, 1.0])
def test_one_frame_adds_the_same_variances_however_rates_are_damped(damping):
    expected = np.array([2.0, 0.1 * DEGREE**2, 1.0, 0.1 * DEGREE**2])
    rates = 625 * np.array([3.0, 0.05 * DEGREE**2, 1.0, 0.02 * DEGREE**2])
    np.testing.assert_allclose(variances(FRAME, damping), np.concatenate((expected, rates)))


def test_within_a_frame_places_spread_in_proportion_to_the_time():
    np.testing.assert_allclose(variances(FRAME / 2)[:4], variances(FRAME)[:4] / 2)


@pytest.mark.parametrize("damping", [0.0, 0.9, 1.0])
def test_no_time_spreads_nothing(damping):
    assert (variances(0.0, damping) == 0.0).all()
    assert effective_time(damping, 0.0) == 0.0


@given(st.floats(0.0, 1.0), st.floats(1e-3, 3600.0), st.floats(1.01, 10.0))
def test_over_a_longer_gap_every_place_spreads_more_and_stays_finite(damping, dt, factor):
    shorter, longer = variances(dt, damping), variances(dt * factor, damping)
    assert np.isfinite(longer).all()
    assert (longer[:4] > shorter[:4]).all()
    assert (longer[4:] >= shorter[4:] * (1 - 1e-12)).all()


@pytest.mark.parametrize("gap", [0.3, 3.0])
@pytest.mark.parametrize(("end", "near"), [(1.0, 1 - 1e-9), (1.0, 1 - 1e-6), (0.0, 1e-300)])
def test_a_damping_next_to_the_end_of_its_range_is_like_the_end(gap, end, near):
    # Towards zero it goes as slowly as a logarithm.
    np.testing.assert_allclose(variances(gap, near), variances(gap, end), rtol=2e-3)
    assert effective_time(near, gap) == pytest.approx(effective_time(end, gap), rel=1e-3)


@pytest.mark.parametrize("frames", [2, 3, 5, 50])
@pytest.mark.parametrize("damping", [0.5, 0.9, 1.0])
def test_damped_rates_spread_as_far_as_frame_by_frame(frames, damping):
    # The exact sum over frames: a rate's change in frame j carries the place in all later ones.
    carried = np.array([(damping ** np.arange(later)).sum() for later in range(frames)])
    expected = 2.0 * frames + 3.0 * (carried**2).sum()
    assert variances(frames * FRAME, damping)[0] == pytest.approx(expected)
    kept = 625 * 3.0 * (damping ** (2 * np.arange(frames))).sum()
    assert variances(frames * FRAME, damping)[4] == pytest.approx(kept)


def test_after_a_gap_the_prior_is_as_wide_as_it_would_be_frame_by_frame(rng):
    parameters = SOME.replaced(
        {
            **FREE,
            "diffusion_degrees_of_freedom": 0.0,
            "angle_variance": 0.0,
            "angle_rate_variance": 0.0,
        }
    )
    states = at_once = np.tile(START, (4000, 1))
    for _ in range(20):
        states = moved(parameters, FRAME, rng, states)
    at_once = moved(parameters, 20 * FRAME, rng, at_once)
    for column in (0, 2, 4, 6):
        assert at_once[:, column].std() == pytest.approx(states[:, column].std(), rel=0.1)


@pytest.mark.parametrize("frames", [1, 2, 5, 20])
@pytest.mark.parametrize("damping", [0.0, 0.5, 0.9, 1.0])
def test_places_and_rates_vary_together_as_frame_by_frame(frames, damping):
    # A rate's change is damped from then on, and the sum of what is left has moved the cable.
    left = damping ** np.arange(frames)
    carried = np.concatenate(([0.0], np.cumsum(left)[:-1]))
    parameters = SOME.replaced({"rate_damping": damping})
    _, shared = spread_of(parameters, frames * FRAME)
    assert shared[0] == pytest.approx(25 * 3.0 * (left * carried).sum())


@given(st.floats(0.0, 1.0), st.floats(1e-3, 3600.0))
def test_the_diffusion_of_rates_has_their_variance_however_much_the_places_explain(damping, dt):
    parameters = SOME.replaced({"rate_damping": damping})
    found = CableMovement(parameters, 320).diffusion(dt)
    explained = (found.rate_gains * found.pose_scales) ** 2
    np.testing.assert_allclose(explained + found.rate_scales**2, variances(dt, damping)[4:])


@pytest.mark.parametrize("dt", [0.0, FRAME / 2, FRAME])
def test_within_a_reference_frame_the_diffusion_of_rates_is_independent_of_that_of_places(dt):
    assert (CableMovement(SOME, 320).diffusion(dt).rate_gains == 0.0).all()


def test_a_particle_that_has_gone_far_goes_fast(rng):
    distances, rates = moved(thesis(), 0.5, rng)[:, [0, 4]].T
    _, shared = spread_of(preset("thesis"), 0.5)
    assert np.cov(distances, rates)[0, 1] == pytest.approx(shared[0], rel=0.05)


@pytest.mark.parametrize("dt", [FRAME / 2, FRAME, 0.5])
def test_particles_spread_with_the_variances_of_the_diffusion(dt, rng):
    spread = moved(thesis(), dt, rng).var(axis=0)
    # Five standard errors of a variance.
    expected = variances_of(preset("thesis"), dt)
    np.testing.assert_allclose(spread, expected, rtol=5 * np.sqrt(2 / COUNT), atol=1e-15)


@pytest.mark.parametrize(("tail", "factor"), [(0.0, 1.0), (10.0, 1.25)])
def test_the_variances_of_heavy_tails_exceed_the_squared_scales(tail, factor, rng):
    still = {**STILL, "distance_variance": 4.0, "diffusion_degrees_of_freedom": tail}
    distances = moved(thesis(**still), FRAME, rng)[:, 0]
    assert distances.var() == pytest.approx(4.0 * factor, rel=0.06)


def test_heavy_tails_keep_the_middle_and_throw_a_few_far(rng):
    heavy, light = (
        np.abs(moved(thesis(diffusion_degrees_of_freedom=tail), FRAME, rng)[:, 0] - START[0] - 1.2)
        / np.sqrt(0.5)
        for tail in (4.0, 0.0)
    )
    # Quantiles of |t| with 4 degrees of freedom, and of a Gaussian.
    assert np.median(heavy) == pytest.approx(0.741, rel=0.03)
    assert np.median(light) == pytest.approx(0.674, rel=0.03)
    assert (heavy > 4.604).mean() == pytest.approx(0.01, rel=0.3)
    assert (light > 4.604).mean() < 1e-3


def test_places_and_rates_jump_independently(rng):
    states = moved(thesis(diffusion_degrees_of_freedom=3.0), FRAME, rng)
    place, rate = np.abs(states[:, 0] - START[0] - 1.2), np.abs(states[:, 4] - START[4])
    width = np.abs(states[:, 2] - START[2] - 0.16)
    far = place > np.quantile(place, 0.99)
    assert np.median(rate[far]) == pytest.approx(np.median(rate), rel=0.2)
    assert np.median(width[far]) > 2 * np.median(width)


def test_lengths_scale_with_the_image_and_angles_do_not():
    small, large = (variances_of(SOME, FRAME, width) for width in (320, 640))
    np.testing.assert_allclose(large / small, [4.0, 1.0, 4.0, 1.0] * 2)
    parameters = TrackerParameters()
    small_box, large_box = (state_limits(parameters, width) for width in (320, 640))
    np.testing.assert_allclose(large_box.upper[[0, 2, 3]] / small_box.upper[[0, 2, 3]], [2, 2, 1])


def test_undamped_rates_carry_the_cable_their_way(rng):
    end = moved(thesis(**STILL), 0.5, rng, START[None, :])[0]
    np.testing.assert_allclose(end, [20.0, 0.2, 82.0, 0.05, 30.0, 0.2, 4.0, 0.1])


def test_a_damped_rate_carries_the_cable_one_frame_and_is_damped_then(rng):
    end = moved(thesis(rate_damping=0.8, **STILL), FRAME, rng, START[None, :])[0]
    expected = [*START[:4] + START[4:] * FRAME, *START[4:] * 0.8]
    np.testing.assert_allclose(end, expected)


@example(np.nextafter(1.0, 0.0), 1.5, 1.5)
@given(st.floats(0.0, 1.0), st.floats(1e-3, 2.0), st.floats(1e-3, 2.0))
def test_two_steps_move_the_cable_as_one_of_their_sum(damping, first, second):
    parameters = thesis(rate_damping=damping, **STILL)
    rng = np.random.default_rng(0)
    halfway = moved(parameters, first, rng, START[None, :])
    end = moved(parameters, second, rng, halfway)
    np.testing.assert_allclose(
        end, moved(parameters, first + second, rng, START[None, :]), rtol=1e-9, atol=1e-9
    )


def test_angles_are_wrapped_with_the_whole_line(rng):
    state = np.array([[5.0, np.pi / 2 - 0.01, 30.0, 0.1, 10.0, 1.0, 5.0, 0.5]])
    end = moved(thesis(**STILL), FRAME, rng, state)[0]
    expected = [-5.4, -np.pi / 2 + 0.03, 30.2, -0.12, -10.0, 1.0, 5.0, -0.5]
    np.testing.assert_allclose(end, expected)


def test_the_states_given_are_not_changed(rng):
    states = np.tile(START, (3, 1))
    moved(TrackerParameters(), FRAME, rng, states)
    np.testing.assert_array_equal(states, np.tile(START, (3, 1)))
