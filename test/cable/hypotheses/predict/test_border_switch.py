from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.predict.border_switch import (
    ANGLE_SIGMA,
    COMBINATIONS,
    OFFSET_SIGMA,
    place_switches,
    switch_density,
    switch_from,
)
from cable_tracker.cable.hypotheses.predict.frame_noise import draw_frame_noise
from cable_tracker.cable.model.geometry import project_borders

LEADER = np.array([20.0, 0.3, 40.0, 0.05])
SWITCH = switch_from(LEADER, 3.0, 240.0, 1.0)


def drawn(rng, count) -> np.ndarray:
    states = np.full((count, 8), np.nan)
    place_switches(states, 0, count, SWITCH, draw_frame_noise(rng, count, 0, 4.0))
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
