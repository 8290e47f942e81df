from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.belief import RememberedCable, remember
from cable_tracker.cable.hypotheses.births import (
    ANGLE_SIGMA,
    COMBINATIONS,
    MAP_SHARE,
    OFFSET_SIGMA,
    BirthDensity,
    birth_density,
    births_anywhere,
    draw_births,
    drawn_birth_density,
    place_switches,
    switch_density,
)
from cable_tracker.cable.hypotheses.frame_inputs import draw_frame_noise
from cable_tracker.cable.hypotheses.prediction import births_with_memory, switch_from
from cable_tracker.cable.model.geometry import (
    image_reaches,
    inset,
    project_borders,
    segment_inside,
    states_in_chart,
    wrap_states,
)
from cable_tracker.cable.model.initial_state import search_box
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.tracking.rates import survival_probability, survival_rates

SIZE = (320, 240)
PARAMETERS = TrackerParameters(
    disappearance_rate=0.25, leaving_rate=10.0, leaving_margin=8.0, memory_time=4.0
)
ANGLES = st.floats(-np.pi / 2, np.pi / 2)

LEADER = np.array([20.0, 0.3, 40.0, 0.05])
SWITCH = switch_from(LEADER, 3.0, 240.0, 1.0)


def cable(distance, angle=0.0, width=30.0, skew=0.0) -> np.ndarray:
    return np.array([distance, angle, width, skew, 0.0, 0.0, 0.0, 0.0])


def remembered(state, side=0.0, seconds=0.0) -> RememberedCable:
    return RememberedCable(state[:4], side, inset(state, *SIZE), np.log(state[2]), seconds=seconds)


def last_seen(state) -> RememberedCable:
    return remember(None, state, SIZE, 0.0, PARAMETERS, 1.0)


def births(memory=None, parameters=PARAMETERS, size=SIZE) -> BirthDensity:
    box = search_box(parameters, size[0])
    scale = size[0] / 320
    anywhere = births_anywhere(box, size, scale)
    if memory is None:
        return anywhere
    return births_with_memory(anywhere, memory, parameters.memory_time, scale)


def density_at(state, density) -> float:
    return birth_density(state, drawn_birth_density(state, density), density)


def densities(density, states) -> np.ndarray:
    return np.array([density_at(state, density) for state in states])


def survival_probabilities(states, size, parameters, dt) -> np.ndarray:
    rates = survival_rates(
        parameters.disappearance_rate, parameters.leaving_rate, parameters.leaving_margin, size[0]
    )
    return np.array([survival_probability(inset(state, *size), rates, dt) for state in states])


@given(ANGLES)
def test_a_line_meets_the_image_up_to_the_support_and_not_beyond(angle):
    reach = float(image_reaches(np.array(angle), (321, 241)))  # Lines are clipped to pixel centres.
    assert segment_inside(angle, reach - 1.5, (321, 241)) is not None
    assert segment_inside(angle, reach + 0.1, (321, 241)) is None


@given(st.floats(-300, 300), ANGLES)
def test_how_far_a_line_is_inside_does_not_depend_on_how_it_is_written(distance, angle):
    states = np.array([cable(distance, angle), cable(-distance, angle + np.pi)])
    here, there = (inset(state, *SIZE) for state in states)
    assert here == pytest.approx(there, abs=1e-9)


def test_survival_falls_toward_the_edge_and_hardly_any_cable_survives_beyond():
    states = np.array([cable(distance) for distance in (0.0, 100.0, 140.0, 155.0, 165.0, 220.0)])
    survival = survival_probabilities(states, SIZE, PARAMETERS, 1.0)
    assert (np.diff(survival) < 0.0).all()
    assert survival[0] == pytest.approx(np.exp(-0.25), rel=1e-6)
    assert survival[-1] < 1e-4
    assert survival_probabilities(states, SIZE, PARAMETERS, 0.0) == pytest.approx(np.ones(6))


@given(st.floats(0.0, 2.0), st.floats(0.0, 2.0))
def test_surviving_two_times_is_surviving_their_sum(first, second):
    state = cable(150.0)[None, :]
    one, two, both = (
        survival_probabilities(state, SIZE, PARAMETERS, dt)[0]
        for dt in (first, second, first + second)
    )
    assert one * two == pytest.approx(both)


def test_the_same_scene_twice_as_large_survives_alike():
    large = survival_probabilities(cable(300.0)[None], (640, 480), PARAMETERS, 0.5)
    np.testing.assert_allclose(
        large, survival_probabilities(cable(150.0)[None], SIZE, PARAMETERS, 0.5)
    )


MEMORIES = {
    "none": None,
    "in the middle": remembered(cable(20.0, 0.3), 0.0, 0.1),
    "in the middle, long ago": remembered(cable(20.0, 0.3), 0.0, 3.0),
    "left by a side": remembered(cable(150.0, 0.1), 1.0, 0.5),
    "left by a side, long ago": remembered(cable(-150.0, -0.1), -1.0, 5.0),
    "beside the wrap": remembered(cable(20.0, np.pi / 2 - 0.01), 0.0, 0.1),
    "forgotten": remembered(cable(20.0, 0.3), 0.0, 1e4),
}


@pytest.mark.parametrize("memory", MEMORIES.values(), ids=MEMORIES)
def test_births_are_drawn_from_their_density(memory, rng):
    """The mean of g / density over draws is the integral of g, here of a box and of half of it."""
    density = births(memory)
    draws = draw_births(density, 10_000, rng)
    assert ((draws[:, 1] > -np.pi / 2) & (draws[:, 1] <= np.pi / 2)).all()
    lower, upper = (limit[:4] for limit in density.box)
    within = ((draws[:, :4] >= lower) & (draws[:, :4] <= upper)).all(axis=1)
    whole = within / densities(density, draws) / np.prod(upper - lower)
    for ratios, expected in ((whole, 1.0), (whole * (draws[:, 0] > 0), 0.5)):
        error = ratios.std() / np.sqrt(len(ratios))
        assert ratios.mean() == pytest.approx(expected, abs=5 * error + 1e-9)
        assert error < 0.05


@pytest.mark.parametrize("kind", [kind for kind in MEMORIES if kind not in ("none", "forgotten")])
def test_births_about_the_remembered_cable_are_drawn_from_their_density(kind, rng):
    """The mean of one over the density, over draws within a box, is the volume of the box."""
    memory = MEMORIES[kind]
    density = births(memory)
    draws = states_in_chart(draw_births(density, 20_000, rng), memory.pose[1])
    near = draws[: round(density.share * len(draws)), :4]
    lower, upper = np.quantile(near, (0.2, 0.8), axis=0)
    within = ((draws[:, :4] >= lower) & (draws[:, :4] <= upper)).all(axis=1)
    volumes = np.zeros(len(draws))
    volumes[within] = 1.0 / densities(density, draws[within])
    error = volumes.std() / np.sqrt(len(volumes)) / np.prod(upper - lower)
    assert volumes.mean() / np.prod(upper - lower) == pytest.approx(1.0, abs=4.0 * error)
    assert error < 0.04


@given(st.floats(-170, 170), ANGLES, st.floats(7, 100), st.floats(-0.1, 0.1))
def test_the_density_of_births_does_not_depend_on_how_a_line_is_written(d, alpha, w, beta):
    one, other = cable(d, alpha, w, beta), cable(-d, alpha + np.pi, w, -beta)
    density = births(MEMORIES["left by a side"])
    np.testing.assert_allclose(density_at(one, density), density_at(other, density), rtol=1e-6)


@pytest.mark.parametrize("angle", [-0.5, 0.0, 0.7])
def test_a_cable_that_left_is_looked_for_along_its_side_whatever_its_angle(angle, rng):
    memory = replace(last_seen(cable(155.0, 0.05)), seconds=0.3)
    density = births(memory)
    at_the_edge = image_reaches(np.array([angle]), SIZE)[0] - 5.0
    here, there, across = (
        np.log(density_at(cable(distance, angle), density))
        for distance in (at_the_edge, 0.3 * at_the_edge, -at_the_edge)
    )
    assert here > there + 0.5
    assert here > across + 0.5
    draws = draw_births(density, 3000, rng)
    assert (np.abs([inset(draw, *SIZE) for draw in draws]) < 30.0).mean() > 0.4
    right = project_borders(draws).offsets.mean(axis=1) * np.cos(draws[:, 1])
    assert (right > 0.0).mean() > 0.7


def test_a_cable_that_vanished_in_the_middle_is_looked_for_there(rng):
    memory = replace(last_seen(cable(20.0, 0.3)), seconds=0.1)
    draws = draw_births(births(memory), 3000, rng)
    near = (np.abs(draws[:, 0] - 20.0) < 40.0) & (np.abs(draws[:, 1] - 0.3) < 0.3)
    assert 0.5 < near.mean() < 0.75


def test_the_longer_it_is_gone_the_farther_it_is_looked_for(rng):
    memory = last_seen(cable(20.0, 0.3))
    spreads = [
        np.median(
            np.abs(draw_births(births(replace(memory, seconds=seconds)), 4000, rng)[:, 0] - 20.0)
        )
        for seconds in (0.0, 0.5, 2.0, 60.0)
    ]
    assert spreads == sorted(spreads)
    uniform = np.median(np.abs(draw_births(births(), 4000, rng)[:, 0] - 20.0))
    assert spreads[-1] == pytest.approx(uniform, rel=0.1)


def test_births_that_are_drawn_are_wrapped(rng):
    draws = draw_births(births(MEMORIES["beside the wrap"]), 2000, rng)
    np.testing.assert_allclose(wrap_states(draws), draws)


def by_map(*strips, memory=None) -> BirthDensity:
    return births(memory)._replace(map_strips=np.array(strips))


@given(st.floats(-170, 170), ANGLES, st.floats(7, 100), st.floats(-0.1, 0.1))
def test_the_density_by_a_map_does_not_depend_on_how_a_line_is_written(d, alpha, w, beta):
    one, other = cable(d, alpha, w, beta), cable(-d, alpha + np.pi, w, -beta)
    density = by_map(cable(20.0, 0.3), cable(-40.0, 1.5, 20.0))
    assert density_at(one, density) == pytest.approx(density_at(other, density), rel=1e-6)


@pytest.mark.parametrize(
    "memory", [pytest.param(None, marks=pytest.mark.slow), MEMORIES["in the middle"]]
)
def test_a_map_moves_a_part_of_the_births_to_its_strips(memory, rng):
    """The integrals over a box far from the strip, and over one about it."""
    strip = cable(-60.0, -0.4, 20.0)
    before, after = births(memory), by_map(strip, memory=memory)
    far = cable(90.0, 0.9, 60.0)
    assert density_at(far, after) == pytest.approx((1.0 - MAP_SHARE) * density_at(far, before))
    reach = 12.0 * after.map_scales
    near = np.zeros((200_000, 8))
    near[:, :4] = strip[:4] + rng.uniform(-reach, reach, (len(near), 4))
    gained = [birth_density(state, 0.0, after) for state in near]
    assert np.mean(gained) * np.prod(2.0 * reach) == pytest.approx(MAP_SHARE, rel=0.1)


def test_births_are_shared_equally_by_two_strips_of_the_map():
    one, other = cable(-60.0, -0.4, 20.0), cable(80.0, 0.5, 50.0)
    both, single = by_map(one, other), by_map(one)
    assert birth_density(one, 0.0, both) == pytest.approx(0.5 * birth_density(one, 0.0, single))


def test_births_are_not_drawn_by_the_map(rng):
    """About its strips particles are drawn in rounds."""
    strip = cable(-60.0, -0.4, 20.0)
    assert drawn_birth_density(strip, by_map(strip)) == drawn_birth_density(strip, births())


def drawn(rng, count) -> np.ndarray:
    states = np.full((count, 8), np.nan)
    noise = draw_frame_noise(rng, count, 0, 4.0)
    place_switches(states, 0, count, SWITCH, noise.normal, noise.uniform)
    return states


def test_every_strip_shares_a_border_on_one_side_or_the_other(rng):
    states = drawn(rng, 400)
    borders = project_borders(states)
    own = project_borders(LEADER[None, :])
    for combination in range(COMBINATIONS):
        shared, side = combination // 2, combination % 2
        rows = slice(combination, None, COMBINATIONS)
        angles = borders.angles[rows, side] - own.angles[0, shared]
        assert np.abs(angles).max() < 5.0 * ANGLE_SIGMA
        distances = states[rows, 0] + (side - 0.5) * states[rows, 2] - SWITCH.crossings[shared]
        assert np.abs(distances).max() < 5.0 * OFFSET_SIGMA


def test_widths_are_of_any_octave_within_the_limits(rng):
    widths = drawn(rng, 4000)[:, 2]
    assert widths.min() >= 3.0
    assert widths.max() <= 240.0
    assert np.median(widths) == pytest.approx(np.sqrt(3.0 * 240.0), rel=0.1)


def test_the_density_is_that_of_what_is_drawn(rng):
    # The mean of one over the density, over a box, is the volume of the box times the share in it.
    states = drawn(rng, 40_000)
    low = np.array([-60.0, 0.25, 20.0, -0.05])
    high = np.array([100.0, 0.35, 60.0, 0.15])
    inside = ((states[:, :4] >= low) & (states[:, :4] <= high)).all(axis=1)
    box = np.zeros((40_000, 8))
    box[:, :4] = rng.uniform(low, high, (40_000, 4))
    volume = float(np.prod(high - low))
    mass = volume * np.mean([switch_density(state, SWITCH) for state in box])
    assert inside.mean() == pytest.approx(mass, rel=0.1)


def test_widths_beyond_the_limits_are_impossible():
    assert switch_density(np.array([20.0, 0.3, 250.0, 0.05]), SWITCH) == 0.0
    assert switch_density(np.array([20.0, 0.3, 2.0, 0.05]), SWITCH) == 0.0
