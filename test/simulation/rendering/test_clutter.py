from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cable_tracker.simulation.rendering.clutter import (
    Streak,
    draw_streak,
    random_companions,
    random_streaks,
    random_track,
    streak_cover,
)
from cable_tracker.simulation.rendering.laid_cable import Bend, Tube

ROPE = Streak(
    p=0.0, q=10.0, angle=np.pi / 2, half_width=0.5, half_length=5.0,
    tone=0.5, opacity=1.0, twist=0.0, on_top=True,
)  # fmt: skip


def _grid():
    p, q = np.meshgrid(np.linspace(-8, 8, 161), np.linspace(0, 8, 81))
    p, q = p.astype(np.float32), q.astype(np.float32)
    return p, q, np.full(p.shape, 0.05, dtype=np.float32)


def test_no_clutter_no_streaks():
    assert random_streaks(0.0, 1000.0, 0.0, np.random.default_rng(0)) == ()


def test_more_clutter_more_streaks():
    few, many = (
        random_streaks(0.0, 1000.0, clutter, np.random.default_rng(0)) for clutter in (0.2, 1.0)
    )
    assert 0 < len(few) < len(many)


def test_streaks_lie_where_they_were_asked_for():
    streaks = random_streaks(-50.0, 150.0, 1.0, np.random.default_rng(1))
    assert all(-55.0 <= streak.q <= 155.0 for streak in streaks)


def test_both_kinds_occur():
    streaks = random_streaks(0.0, 1000.0, 1.0, np.random.default_rng(2))
    assert {streak.twist > 0 for streak in streaks} == {True, False}


def test_a_rope_comes_closer_with_the_way_travelled():
    p, q, footprint = _grid()
    cover = streak_cover(ROPE, p, q, 6.0, footprint)
    assert cover is not None
    covered = cover > 0.5
    assert covered[40, 80]
    assert np.abs(q[covered] - 4.0).max() <= 0.5
    assert np.abs(p[covered]).max() <= 5.0


def test_a_rope_far_ahead_or_behind_costs_nothing():
    p, q, footprint = _grid()
    assert streak_cover(ROPE, p, q, -20.0, footprint) is None
    assert streak_cover(ROPE, p, q, 40.0, footprint) is None


def test_a_track_is_two_parallel_furrows():
    first, second = random_track(5.0, np.random.default_rng(3))
    assert first.angle == second.angle
    apart = np.array((second.p - first.p, second.q - first.q))
    across = (np.cos(first.angle), np.sin(first.angle))
    assert np.dot(apart, across) > 2 * first.half_width
    assert abs(np.cross(np.append(apart, 0), np.append(across, 0))[2]) < 1e-12


TUBE = Tube(0.08, (Bend(0.05, 0.5, 0.3),))
FURROW = Streak(
    p=0.0, q=4.0, angle=0.0, half_width=0.5, half_length=20.0,
    tone=0.1, opacity=0.0, twist=0.0, on_top=False, relief=0.4,
)  # fmt: skip


def _companions(amount):
    return random_companions(TUBE, 0.0, 2000.0, amount, np.random.default_rng(4))


def test_more_companions_when_more_are_asked_for():
    assert _companions(0.0) == ()
    assert 0 < len(_companions(0.3)) < len(_companions(1.0))


def test_companions_run_alongside_the_cable():
    for streak in _companions(1.0):
        points, directions = TUBE.axis(np.array([streak.q * TUBE.radius]))
        axis = points[0, 0] / TUBE.radius
        lean = np.arctan2(-directions[0, 0], directions[0, 1])
        assert abs(streak.p - axis) < 8.0
        assert abs(streak.angle - lean) < np.deg2rad(30)


def test_some_companions_are_pairs_as_far_apart_as_the_borders_of_a_cable():
    streaks = _companions(1.0)
    pairs = [abs(one.p - other.p) for one, other in pairwise(streaks) if one.q == other.q]
    assert len(pairs) > 5
    assert 1.2 <= min(pairs) <= max(pairs) <= 2.6


@pytest.mark.parametrize("relief", [0.4, -0.4])
def test_one_slope_of_a_furrow_is_lit_and_the_other_shaded(relief):
    p, q, footprint = _grid()
    bottom = np.full(p.shape, 0.3, dtype=np.float32)
    furrow = replace(FURROW, relief=relief)
    drawn = draw_streak(bottom, furrow, p, q, 0.0, footprint=footprint)
    left, right = drawn[40, 75], drawn[40, 85]
    assert left - 0.3 == pytest.approx(0.3 - right, abs=1e-4)
    assert np.sign(right - left) == np.sign(relief)
    np.testing.assert_allclose(drawn[:, :20], 0.3, atol=1e-4)
