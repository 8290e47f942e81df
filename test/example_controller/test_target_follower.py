import math

import numpy as np
import pytest

from cable_tracker.example_controller.command import HOLD_TIME
from cable_tracker.example_controller.target_follower import (
    FollowMode,
    FollowSettings,
    TargetController,
    TargetPlace,
)

DT = 0.08


def run(follower, places, start=0.0):
    return [follower.step(start + number * DT, place) for number, place in enumerate(places)]


def test_the_follower_waits_until_a_target_is_seen():
    follower = TargetController(FollowSettings())
    assert run(follower, [None] * 5)[-1].surge == 0.0
    assert follower.mode is FollowMode.WAITING


@pytest.mark.parametrize(("ahead", "sign"), [(6.0, 1.0), (1.0, -1.0)])
def test_too_far_it_goes_on_and_too_near_it_backs_off(ahead, sign):
    follower = TargetController(FollowSettings(distance=2.5))
    command = run(follower, [TargetPlace(ahead, 0.0, 0.0)] * 3)[-1]
    assert math.copysign(1.0, command.surge) == sign
    assert -0.4 <= command.surge <= 0.8


def test_the_follower_turns_and_climbs_towards_the_target():
    follower = TargetController(FollowSettings())
    command = run(follower, [TargetPlace(3.0, 1.0, 0.5)])[-1]
    assert command.turn > 0.0
    assert command.heave > 0.0
    assert abs(run(follower, [TargetPlace(0.1, -3.0, 0.0)])[-1].turn) == 0.5


def test_the_follower_keeps_its_distance_behind_a_moving_target():
    follower = TargetController(FollowSettings(distance=2.5))
    gap, speed = 5.0, 0.35
    for number in range(2000):
        command = follower.step(number * DT, TargetPlace(gap, 0.0, 0.0))
        gap += (speed - command.surge) * DT
    assert gap == pytest.approx(2.5, abs=0.05)
    # What it has learnt of the speed carries it on when the target is gone.
    assert follower.step(2000 * DT + HOLD_TIME, None).surge == pytest.approx(speed, abs=0.05)
    assert follower.mode is FollowMode.REMEMBERING


def test_the_last_command_goes_on_for_a_moment():
    follower = TargetController(FollowSettings())
    before = run(follower, [TargetPlace(4.0, 0.3, 0.5)] * 3)[-1]
    seen = 2 * DT
    assert before.surge > 0.7
    for passed in (DT, HOLD_TIME - 0.01):
        assert follower.step(seen + passed, None) == before
        assert follower.mode is FollowMode.FOLLOWING
    assert follower.step(seen + HOLD_TIME + DT, None).surge < 0.1
    assert follower.mode is FollowMode.REMEMBERING


def test_a_lost_target_is_looked_for_on_the_side_where_it_was_and_then_given_up():
    follower = TargetController(FollowSettings(memory_time=2.0, give_up=10.0))
    follower.step(0.0, TargetPlace(3.0, -1.0, 0.0))
    assert follower.step(2.5, None).turn < 0.0
    assert follower.mode is FollowMode.SEARCHING
    # To that side at first, then to the other one.
    turns = [follower.step(5.0 + 0.1 * number, None).turn for number in range(40)]
    assert min(turns) < 0.0 < max(turns)
    command = follower.step(20.0, None)
    assert (command.surge, command.turn) == (0.0, 0.0)
    assert follower.mode is FollowMode.GIVEN_UP
    follower.step(21.0, TargetPlace(3.0, 0.0, 0.0))
    assert follower.mode is FollowMode.FOLLOWING


@pytest.mark.parametrize(("search_turn", "most_turn"), [(0.3, 0.5), (0.5, 0.3)])
def test_each_leg_of_the_search_goes_farther_beyond_the_course_than_the_one_before(
    search_turn, most_turn
):
    settings = FollowSettings(
        memory_time=0.0, search_turn=search_turn, most_turn=most_turn, search_angle=0.4
    )
    follower = TargetController(settings)
    follower.step(0.0, TargetPlace(3.0, 0.0, 0.0))
    turns = np.array([follower.step(0.01 * number, None).turn for number in range(41, 4040)])
    assert np.abs(turns).max() == 0.3
    headings = np.cumsum(0.01 * turns)
    farthest = headings[np.flatnonzero(np.diff(np.sign(turns)))]
    assert farthest[:4] == pytest.approx([0.4, -0.8, 1.2, -1.6], abs=0.02)


def test_without_a_rate_of_turn_it_does_not_look_around():
    follower = TargetController(FollowSettings(memory_time=1.0, search_turn=0.0))
    follower.step(0.0, TargetPlace(3.0, 1.0, 0.0))
    assert follower.step(5.0, None).turn == 0.0
    assert follower.mode is FollowMode.SEARCHING


@pytest.mark.parametrize("back", [10.0, 990.0])
def test_a_clock_that_is_set_back_does_not_turn_the_vehicle_faster(back):
    follower = TargetController(FollowSettings())
    follower.step(1000.0, TargetPlace(2.5, 1.0, 0.0))
    turns = [abs(follower.step(1000.0 - back + number * DT, None).turn) for number in range(2000)]
    assert max(turns) <= FollowSettings().most_turn
    assert follower.mode is FollowMode.GIVEN_UP


def test_a_memory_longer_than_the_patience_does_not_lengthen_it():
    follower = TargetController(FollowSettings(memory_time=120.0, give_up=60.0))
    follower.step(0.0, TargetPlace(2.5, 1.0, 0.0))
    follower.step(61.0, None)
    assert follower.mode is FollowMode.GIVEN_UP
