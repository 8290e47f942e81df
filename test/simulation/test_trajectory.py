import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.simulation.trajectory import (
    ANGLE_LIMIT,
    DISTANCE_LIMIT,
    WIDTH_LIMITS,
    Harmonics,
    Trajectory,
)

SEEDS = st.integers(0, 10_000)
TIMES = st.floats(0.0, 3600.0)


def _states(size, seed, rate=25.0, count=1500):
    trajectory = Trajectory.random(size, np.random.default_rng(seed))
    return np.array([trajectory.state(index / rate).to_array() for index in range(count)])


@given(SEEDS, TIMES)
def test_stays_within_its_limits(seed, time):
    state = Trajectory.random((320, 240), np.random.default_rng(seed)).state(time)
    assert abs(state.distance) <= DISTANCE_LIMIT + 1e-9
    assert abs(state.angle) <= ANGLE_LIMIT + 1e-9
    assert WIDTH_LIMITS[0] - 1e-9 <= state.width <= WIDTH_LIMITS[1] + 1e-9
    assert 0.8 <= np.rad2deg(state.skew) <= 6.0


@given(SEEDS, TIMES)
def test_borders_meet_outside_the_image(seed, time):
    state = Trajectory.random((320, 240), np.random.default_rng(seed)).state(time)
    assert state.width / 2 / np.tan(state.skew) > np.hypot(320, 240) / 2


@given(SEEDS, TIMES)
def test_velocities_are_derivatives(seed, time):
    trajectory = Trajectory.random((320, 240), np.random.default_rng(seed))
    before, now, after = (trajectory.state(time + step) for step in (-1e-4, 0.0, 1e-4))
    assert now.distance_rate == pytest.approx((after.distance - before.distance) / 2e-4, abs=1e-2)
    assert now.angle_rate == pytest.approx((after.angle - before.angle) / 2e-4, abs=1e-4)


@given(SEEDS, TIMES, st.floats(0.001, 10.0))
def test_vehicle_never_goes_backwards(seed, time, step):
    trajectory = Trajectory.random((320, 240), np.random.default_rng(seed))
    assert trajectory.travel(time + step) > trajectory.travel(time)


def test_travel_starts_at_zero():
    assert Trajectory.random((320, 240), np.random.default_rng(3)).travel(0.0) == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_moves_as_briskly_as_a_vehicle(seed):
    steps = np.diff(_states((320, 240), seed), axis=0)
    assert 0.8 < np.sqrt(np.mean(steps[:, 0] ** 2)) < 2.5
    assert 0.2 < np.rad2deg(np.sqrt(np.mean(steps[:, 1] ** 2))) < 0.8


@pytest.mark.parametrize("seed", range(4))
def test_uses_most_of_its_range(seed):
    states = _states((320, 240), seed)
    assert np.ptp(states[:, 0]) > DISTANCE_LIMIT
    assert np.ptp(states[:, 1]) > ANGLE_LIMIT
    assert np.ptp(states[:, 2]) > 5.0


@settings(max_examples=20)
@given(SEEDS, st.integers(32, 4096))
def test_lengths_scale_with_the_width(seed, width):
    small = _states((320, 320), seed, count=20)
    other = _states((width, width), seed, count=20)
    lengths = [0, 2, 4]
    np.testing.assert_allclose(other[:, lengths], small[:, lengths] * width / 320, rtol=1e-9)
    np.testing.assert_allclose(other[:, [1, 3, 5]], small[:, [1, 3, 5]], rtol=1e-9)


def test_same_generator_gives_the_same_motion():
    np.testing.assert_array_equal(_states((320, 240), 5), _states((320, 240), 5))
    assert not np.array_equal(_states((320, 240), 5), _states((320, 240), 6))


def test_sum_of_harmonics_reaches_what_its_amplitudes_say():
    one = Harmonics(np.array([2.0]), np.array([np.pi]), np.array([0.0]))
    assert one.value(0.5) == pytest.approx(2.0)
    assert one.rate(0.0) == pytest.approx(2.0 * np.pi)
