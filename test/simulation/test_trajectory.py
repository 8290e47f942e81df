import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import ParameterError
from cable_tracker.simulation.scenario_dive import (
    ANGLE_LIMIT,
    DISTANCE_LIMIT,
    SKEW_LIMITS,
    WIDTH_LIMITS,
    random_trajectory,
)
from cable_tracker.simulation.trajectory import Harmonics, Move, Pause, Signal

SEEDS = st.integers(0, 10_000)
TIMES = st.floats(0.0, 3600.0)


def _trajectory(seed):
    return random_trajectory(np.random.default_rng(seed))


def _states(seed, width=320, count=1500):
    return _trajectory(seed).states(np.arange(count) / 25, width)


@given(SEEDS, TIMES)
def test_stays_within_its_limits(seed, time):
    distance, angle, width, skew = _trajectory(seed).states(np.array([time]), 320)[0, :4]
    assert abs(distance) <= DISTANCE_LIMIT + 1e-9
    assert abs(angle) <= ANGLE_LIMIT + 1e-9
    assert WIDTH_LIMITS[0] - 1e-9 <= width <= WIDTH_LIMITS[1] + 1e-9
    assert SKEW_LIMITS[0] - 1e-9 <= skew <= SKEW_LIMITS[1] + 1e-9
    assert width / 2 / np.tan(skew) > np.hypot(320, 240) / 2, "the borders meet in the image"


@given(SEEDS, TIMES)
def test_velocities_are_derivatives(seed, time):
    times = time + np.array((-1e-3, 0.0, 1e-3))
    before, now, after = _trajectory(seed).states(times, 320)
    np.testing.assert_allclose(now[4:], (after - before)[:4] / 2e-3, atol=2e-2)


@given(SEEDS, TIMES, st.floats(0.001, 10.0))
def test_vehicle_never_goes_backwards(seed, time, step):
    first, second = _trajectory(seed).travel(np.array((time, time + step)))
    assert second > first


def test_the_way_starts_at_zero():
    assert _trajectory(3).travel(np.zeros(1))[0] == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_moves_as_briskly_as_a_vehicle(seed):
    steps = np.diff(_states(seed), axis=0)
    assert 0.8 < np.sqrt(np.mean(steps[:, 0] ** 2)) < 2.5
    assert 0.2 < np.rad2deg(np.sqrt(np.mean(steps[:, 1] ** 2))) < 0.8


@given(SEEDS, st.integers(32, 4096))
def test_lengths_scale_with_the_width(seed, width):
    small, other = _states(seed, 320, 5), _states(seed, width, 5)
    lengths = [0, 2, 4, 6]
    np.testing.assert_allclose(other[:, lengths], small[:, lengths] * width / 320, rtol=1e-9)
    np.testing.assert_array_equal(other[:, [1, 3, 5, 7]], small[:, [1, 3, 5, 7]])


def test_sum_of_harmonics_reaches_what_its_amplitudes_say():
    one = Harmonics(np.array([2.0]), np.array([np.pi]), np.array([0.0]))
    assert one.values(np.array([0.5]))[0] == pytest.approx(2.0)


def test_a_move_rests_before_and_after():
    move = Move(2.0, 1.0, 8.0)
    assert move.values(np.array([0.0, 2.0, 2.5, 3.0, 9.0])).tolist() == [0.0, 0.0, 4.0, 8.0, 8.0]


def test_a_pause_costs_its_length_and_one_ramp():
    pause = Pause(3.0, 5.0, 1.0)
    times = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])
    assert pause.lost(times) == pytest.approx([0.0, 0.0, 0.5, 1.5, 2.5, 3.0, 3.0])


@given(SEEDS, st.floats(0.5, 20.0))
def test_harmonics_are_scaled_to_a_variance_together_with_the_moves(seed, variance):
    rng = np.random.default_rng(seed)
    harmonics = Harmonics.random(10.0, ((0.2, 0.4), (0.8, 1.2)), rng)
    signal = Signal(5.0, harmonics, (Move(2.0, 1.0, -10.0),), (Move(4.0, 1.0, -0.5),))
    times = np.arange(250) / 25
    scaled = signal.with_increment_variance(variance, times)
    steps = np.diff(scaled.values(times))
    assert np.var(steps, ddof=1) == pytest.approx(variance)


def test_moves_that_are_too_strong_for_a_variance_are_refused():
    harmonics = Harmonics(np.array([1.0]), np.array([1.0]), np.array([0.0]))
    signal = Signal(0.0, harmonics, (Move(1.0, 0.2, 50.0),))
    with pytest.raises(ParameterError, match="less than the scripted moves"):
        signal.with_increment_variance(0.1, np.arange(100) / 25)
