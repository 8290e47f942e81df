from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.cable.movement import (
    CableMovement,
    clip_to_limits,
    diffusion_per_second,
    reflect_at_limits,
    state_limits,
)
from cable_tracker.cable.parameters import TrackerParameters
from cable_tracker.cable.presets import preset

FRAME = 0.04
COUNT = 40_000
DEGREE = np.pi / 180
START = np.array([5.0, 0.1, 80.0, 0.0, 30.0, 0.2])
FREE = {"distance_limit": 1e4, "width_minimum": 0.5, "width_maximum": 1e4, "skew_limit": 80.0}
STILL = dict.fromkeys(
    (
        "distance_variance",
        "angle_variance",
        "width_variance",
        "skew_variance",
        "distance_rate_variance",
        "angle_rate_variance",
    ),
    0.0,
)


def moved(parameters, dt, rng, states=None, width=320):
    states = np.tile(START, (COUNT, 1)) if states is None else states
    return CableMovement(parameters, width).propagate(states, dt, rng)


def thesis(**changes) -> TrackerParameters:
    return preset("thesis").replaced({**FREE, **changes})


def test_one_frame_has_exactly_the_variances_of_the_thesis():
    # Table 5.1; its rates are per frame, ours per second.
    per_frame = diffusion_per_second(preset("thesis"), 320) * FRAME
    expected = [0.5, 0.01 * DEGREE**2, 4.0, 0.1 * DEGREE**2, 8.0 * 625, 0.005 * DEGREE**2 * 625]
    np.testing.assert_allclose(per_frame, expected, rtol=1e-12)


@pytest.mark.parametrize("dt", [FRAME / 2, FRAME, 1.0])
def test_particles_spread_with_the_variances_of_the_thesis_times_the_frames(dt, rng):
    spread = moved(thesis(), dt, rng).var(axis=0)
    expected = diffusion_per_second(preset("thesis"), 320) * dt
    # Five standard errors of a variance.
    np.testing.assert_allclose(spread, expected, rtol=5 * np.sqrt(2 / COUNT))


def test_lengths_scale_with_the_image_and_angles_do_not():
    small, large = (diffusion_per_second(preset("thesis"), width) for width in (320, 640))
    np.testing.assert_allclose(large / small, [4.0, 1.0, 4.0, 1.0, 4.0, 1.0])
    parameters = TrackerParameters()
    small_box, large_box = (state_limits(parameters, width) for width in (320, 640))
    np.testing.assert_allclose(large_box.upper[[0, 2, 3]] / small_box.upper[[0, 2, 3]], [2, 2, 1])


def test_undamped_rates_carry_the_cable_their_way(rng):
    end = moved(thesis(**STILL), 0.5, rng, START[None, :])[0]
    np.testing.assert_allclose(end, [5.0 + 15.0, 0.1 + 0.1, 80.0, 0.0, 30.0, 0.2])


def test_a_damped_rate_carries_the_cable_one_frame_and_is_damped_then(rng):
    end = moved(thesis(rate_damping=0.8, **STILL), FRAME, rng, START[None, :])[0]
    np.testing.assert_allclose(end, [5.0 + 30 * FRAME, 0.1 + 0.2 * FRAME, 80, 0, 24.0, 0.16])


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
    state = np.array([[5.0, np.pi / 2 - 0.01, 30.0, 0.1, 10.0, 1.0]])
    end = moved(thesis(**STILL), FRAME, rng, state)[0]
    np.testing.assert_allclose(end, [-5.4, -np.pi / 2 + 0.03, 30.0, -0.1, -10.0, 1.0])


STATES = arrays(np.float64, (7, 6), elements=st.floats(-1e6, 1e6))


@pytest.mark.parametrize("limit", [clip_to_limits, reflect_at_limits])
@given(states=STATES)
def test_whatever_is_limited_ends_inside(limit, states):
    box = state_limits(TrackerParameters(), 320)
    inside = limit(states, box)
    assert (inside[:, :4] >= box.lower).all()
    assert (inside[:, :4] <= box.upper).all()
    np.testing.assert_array_equal(inside[:, [1, 5]], states[:, [1, 5]])


@pytest.mark.parametrize("handling", ["clip", "reflect"])
@pytest.mark.parametrize("dt", [FRAME, 5.0])
def test_particles_never_leave_the_limits(handling, dt, rng):
    parameters = TrackerParameters(limit_handling=handling)
    box = state_limits(parameters, 320)
    states = np.tile([210.0, 1.5, 5.0, 0.3, 3000.0, 20.0], (2000, 1))
    for _ in range(5):
        states = moved(parameters, dt, rng, states)
        assert (states[:, :4] >= box.lower).all()
        assert (states[:, :4] <= box.upper).all()
        assert (np.abs(states[:, 1]) <= np.pi / 2).all()


def test_reflection_mirrors_and_turns_the_rate():
    box = state_limits(TrackerParameters(), 320)
    states = np.array([[223.0, 0.0, 1.0, 0.0, 50.0, 0.1], [-221.0, 0.0, 163.0, 0.0, -50.0, 0.1]])
    np.testing.assert_allclose(
        reflect_at_limits(states, box),
        [[217.0, 0.0, 7.0, 0.0, -50.0, 0.1], [-219.0, 0.0, 157.0, 0.0, 50.0, 0.1]],
    )


def test_clipping_stops_at_the_limit():
    box = state_limits(TrackerParameters(), 320)
    states = np.array([[223.0, 0.0, 1.0, -1.0, 50.0, 0.1]])
    expected = [[220.0, 0.0, 4.0, -20 * DEGREE, 50.0, 0.1]]
    np.testing.assert_allclose(clip_to_limits(states, box), expected)


def test_the_states_given_are_not_changed(rng):
    states = np.tile(START, (3, 1))
    moved(TrackerParameters(), FRAME, rng, states)
    np.testing.assert_array_equal(states, np.tile(START, (3, 1)))
