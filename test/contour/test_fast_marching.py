import math

import numpy as np
import pytest

from cable_tracker.contour.fast_marching import arrival_times, edge_speed


def swept(speed, seeds):
    """The same equation solved by sweeping until nothing changes."""
    times = np.where(seeds, 0.0, math.inf)
    while True:
        before = times.copy()
        for row, column in np.ndindex(times.shape):
            if seeds[row, column]:
                continue
            beside = np.pad(times, 1, constant_values=math.inf)
            across = min(beside[row + 1, column], beside[row + 1, column + 2])
            down = min(beside[row, column + 1], beside[row + 2, column + 1])
            slow = 1.0 / speed[row, column]
            time = min(across, down) + slow
            if max(across, down) < time:
                time = (across + down + math.sqrt(2 * slow**2 - (across - down) ** 2)) / 2
            times[row, column] = min(times[row, column], time)
        if np.array_equal(before, times):
            return times


def test_arrivals_solve_the_upwind_equation():
    rng = np.random.default_rng(2)
    speed = rng.uniform(0.1, 1.0, (9, 12))
    seeds = np.zeros((9, 12), bool)
    seeds[4, 3] = seeds[0, 11] = True
    np.testing.assert_allclose(arrival_times(speed, seeds, math.inf), swept(speed, seeds))


def test_on_even_ground_the_front_is_a_circle():
    seeds = np.zeros((61, 61), bool)
    seeds[30, 30] = True
    times = arrival_times(np.ones((61, 61)), seeds, math.inf)
    rows, columns = np.mgrid[:61, :61]
    distances = np.hypot(rows - 30, columns - 30)
    assert times == pytest.approx(distances, abs=1.5)
    assert times[30, 60] == 30.0


def test_the_front_stops_in_time():
    seeds = np.zeros((5, 50), bool)
    seeds[:, 0] = True
    times = arrival_times(np.ones((5, 50)), seeds, 20.0)
    assert np.isfinite(times[:, :21]).all()
    assert np.isinf(times[:, 21:]).all()


def test_the_front_waits_at_edges(draw_disc):
    image = np.where(draw_disc(60, 80, (40, 30), 15), 1.0, 0.0).astype(np.float32)
    speed = edge_speed(image, sigma=1.0, gain=20.0)
    assert speed[0, 0] == 1.0
    assert speed[30, 25] < 0.05
    seeds = np.zeros((60, 80), bool)
    seeds[0] = seeds[-1] = True
    seeds[:, 0] = seeds[:, -1] = True
    times = arrival_times(speed, seeds, 60.0)
    assert np.isinf(times[30, 40])
    assert np.isfinite(times[30, 20])
