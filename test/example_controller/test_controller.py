from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.example_controller.cable_memory import Pose, RememberedLine
from cable_tracker.example_controller.command import HOLD_TIME, STOP, Command
from cable_tracker.example_controller.controller import (
    CONFIRMATIONS,
    MOST_SWEEP,
    PAUSE,
    STRAIGHT,
    Controller,
    ControllerSettings,
    Mode,
    sweep,
)
from cable_tracker.example_controller.line_of_sight import CableLine

STEP = 0.1
SETTINGS = ControllerSettings()
AHEAD = CableLine(0.0, 0.0)


class Trial:
    """A controller whose vehicle moves at once as it is told, over a cable along the x axis."""

    def __init__(self, controller: Controller | None = None, has_odometry: bool = True) -> None:
        self.controller = controller or Controller()
        self.has_odometry = has_odometry
        self.time = 0.0
        self.pose = Pose(0.0, 0.0, 0.0)
        self.command = STOP

    @property
    def mode(self) -> Mode:
        return self.controller.mode

    def sees(self, cable: CableLine | None, *, is_processed: bool = True) -> Command:
        self.time += STEP
        pose = self.pose if self.has_odometry else None
        self.command = self.controller.step(self.time, cable, pose, is_processed=is_processed)
        yaw = self.pose.yaw + self.command.turn * STEP
        way = self.command.surge * STEP
        self.pose = Pose(self.pose.x + way * math.cos(yaw), self.pose.y + way * math.sin(yaw), yaw)
        return self.command

    def passes_over_a_frame(self) -> Command:
        return self.sees(None, is_processed=False)

    def sees_the_x_axis(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.sees(CableLine(-self.pose.y / math.cos(self.pose.yaw), -self.pose.yaw))

    def sees_nothing(self, seconds: float) -> Iterator[Command]:
        for _ in range(round(seconds / STEP)):
            yield self.sees(None)


@pytest.fixture
def following() -> Trial:
    trial = Trial()
    trial.sees_the_x_axis(5.0)
    assert trial.mode is Mode.FOLLOWING
    return trial


@given(st.integers(1, 200))
def test_before_the_cable_is_seen_the_vehicle_stands_still(count):
    trial = Trial()
    assert all(trial.sees(None) == STOP for _ in range(count))
    assert trial.mode is Mode.WAITING


def test_the_cable_must_be_seen_several_times_in_a_row():
    trial = Trial()
    for _ in range(3):
        for _ in range(CONFIRMATIONS - 1):
            assert trial.sees(AHEAD) == STOP
        trial.sees(None)
    for _ in range(CONFIRMATIONS):
        trial.sees(AHEAD)
    assert trial.mode is Mode.FOLLOWING
    assert trial.command.surge > 0.0


def test_frames_that_were_refused_neither_confirm_a_cable_nor_interrupt_its_sightings():
    trial = Trial()
    for number in range(CONFIRMATIONS):
        assert trial.mode is Mode.WAITING
        for _ in range(number):
            trial.passes_over_a_frame()
        trial.sees(AHEAD)
    assert trial.mode is Mode.FOLLOWING


def test_the_vehicle_stops_when_all_frames_are_refused(following):
    for _ in range(round((HOLD_TIME + PAUSE) / STEP) - 1):
        following.passes_over_a_frame()
    assert following.command == STOP
    assert following.mode is Mode.STOPPED


def test_a_frame_without_an_answer_changes_nothing(following):
    before = following.command
    assert following.sees(None) == before
    assert following.mode is Mode.FOLLOWING


def test_when_the_cable_is_lost_the_vehicle_stops(following):
    commands = list(following.sees_nothing(HOLD_TIME + PAUSE - STEP))
    assert commands[-1] == STOP
    assert following.mode is Mode.STOPPED


def test_a_vehicle_that_lost_the_cable_searches_along_the_line(following):
    start = following.pose.x
    for command in following.sees_nothing(12.0):
        if following.mode is Mode.SEARCHING:
            assert command.surge <= SETTINGS.search_speed
    assert following.mode is Mode.SEARCHING
    assert following.pose.x > start + 2.0
    assert abs(following.pose.y) < 0.05


def test_the_search_sweeps_to_both_sides(following):
    places = [following.pose.y for _ in following.sees_nothing(60.0)]
    assert max(places) > 0.5
    assert min(places) < -0.5


def test_after_a_long_search_it_gives_up_and_stands_still(following):
    for _ in following.sees_nothing(200.0):
        pass
    assert following.mode is Mode.GIVEN_UP
    assert following.command == STOP


def test_a_search_that_does_not_come_forward_ends_too(following):
    held = following.pose
    for _ in following.sees_nothing(240.0):
        following.pose = held
    assert following.mode is Mode.GIVEN_UP
    assert following.command == STOP


def test_a_moderate_head_current_does_not_shorten_the_search(following):
    start = following.pose.x
    for _ in following.sees_nothing(240.0):
        current = 0.15 * STEP
        following.pose = replace(following.pose, x=following.pose.x - current)
        if following.mode is Mode.GIVEN_UP:
            break
    assert following.mode is Mode.GIVEN_UP
    assert following.pose.x > start + 0.95 * SETTINGS.search_length


def test_the_time_limit_restarts_with_each_search(following):
    held = following.pose
    for _ in range(3):
        for _ in following.sees_nothing(100.0):
            following.pose = held
        assert following.mode is Mode.SEARCHING
        for _ in range(CONFIRMATIONS):
            following.sees(AHEAD)
        assert following.mode is Mode.FOLLOWING
        following.pose = held


def test_a_cable_that_comes_back_is_followed_again(following):
    for _ in following.sees_nothing(12.0):
        pass
    following.sees_the_x_axis(1.0)
    assert following.mode is Mode.FOLLOWING


def test_a_cable_that_comes_back_after_giving_up_is_followed_again(following):
    for _ in following.sees_nothing(200.0):
        pass
    following.sees_the_x_axis(1.0)
    assert following.mode is Mode.FOLLOWING


def test_after_giving_up_a_cable_may_lie_anywhere_but_must_be_seen_in_a_row(following):
    for _ in following.sees_nothing(200.0):
        pass
    elsewhere = CableLine(5.0, 1.0)
    for _ in range(3):
        for _ in range(CONFIRMATIONS - 1):
            assert following.sees(elsewhere) == STOP
        following.sees(None)
    for _ in range(CONFIRMATIONS):
        following.sees(elsewhere)
    assert following.mode is Mode.FOLLOWING


@pytest.mark.parametrize("jump", [Pose(0.0, 1.0, 0.0), Pose(0.0, 0.0, 1.0), Pose(-30.0, 0.0, 0.0)])
def test_odometry_that_jumps_does_not_hide_the_cable(following, jump):
    for _ in range(20):
        pose = following.pose
        following.pose = Pose(pose.x + jump.x, pose.y + jump.y, pose.yaw + jump.yaw)
        jump = Pose(0.0, 0.0, 0.0)
        following.sees(AHEAD)
        assert following.mode is Mode.FOLLOWING
        assert following.command.surge > 0.0


def test_along_a_line_from_before_a_jump_of_odometry_nothing_is_searched(following):
    for _ in following.sees_nothing(4.0):
        pass
    assert following.mode is Mode.SEARCHING
    following.pose = replace(following.pose, y=following.pose.y + 5.0)
    assert following.sees(None) == STOP
    assert following.mode is Mode.STOPPED
    for _ in range(CONFIRMATIONS):
        following.sees(AHEAD)
    assert following.mode is Mode.FOLLOWING


def test_along_a_line_from_before_a_clock_was_set_back_nothing_is_searched(following):
    for _ in following.sees_nothing(4.0):
        pass
    following.time -= 60.0
    assert following.sees(None) == STOP
    assert following.mode is Mode.STOPPED


def test_a_frame_that_was_overtaken_on_the_way_does_not_end_a_search(following):
    list(following.sees_nothing(4.0))
    following.controller.step(following.time - 0.12, None, following.pose)
    list(following.sees_nothing(4.0))
    assert following.mode is Mode.SEARCHING


@pytest.mark.parametrize("blind", [0.0, 5.0])
def test_a_vehicle_that_moves_fast_has_not_jumped(following, blind):
    following.has_odometry = False
    list(following.sees_nothing(blind))
    following.has_odometry = True
    way = 0.8 * (blind + STEP)
    following.pose = replace(following.pose, x=following.pose.x + way, yaw=0.1)
    list(following.sees_nothing(3.0))
    assert following.mode is Mode.SEARCHING


@pytest.mark.parametrize("other", [CableLine(1.5, 0.0), CableLine(-1.5, 0.0), CableLine(0.0, 1.0)])
def test_a_line_far_from_the_followed_one_is_not_followed(following, other):
    for _ in range(20):
        following.sees(other)
    assert following.mode is not Mode.FOLLOWING


@pytest.mark.parametrize("other", [CableLine(0.35, 0.0), CableLine(0.0, math.radians(24.0))])
def test_soon_after_the_loss_the_cable_is_near_the_line_and_later_it_may_have_bent(other):
    soon, late = Trial(), Trial()
    for trial, seconds in ((soon, 1.0), (late, 10.0)):
        trial.sees_the_x_axis(20.0)
        for _ in trial.sees_nothing(seconds):
            pass
        line = RememberedLine(trial.pose.x, other.offset, other.heading)
        for _ in range(2 * CONFIRMATIONS):
            trial.sees(line.relative_to(trial.pose))
    assert soon.mode is not Mode.FOLLOWING
    assert late.mode is Mode.FOLLOWING


def test_a_followed_cable_may_bend(following):
    for step in range(40):
        following.sees(CableLine(0.0, 0.02 * min(step, 20)))
        assert following.mode is Mode.FOLLOWING


def test_a_single_sighting_is_enough_to_search_along():
    trial = Trial()
    for _ in range(CONFIRMATIONS):
        trial.sees(AHEAD)
    assert trial.mode is Mode.FOLLOWING
    for _ in trial.sees_nothing(8.0):
        pass
    assert trial.mode is Mode.SEARCHING
    assert trial.pose.x > 1.0


def test_a_find_that_is_lost_again_soon_does_not_turn_the_search_away(following):
    for _ in following.sees_nothing(4.0):
        pass
    furrow = RememberedLine(following.pose.x, following.pose.y + 0.1, math.radians(25.0))
    for _ in range(35):
        following.sees(furrow.relative_to(following.pose))
    assert following.mode is Mode.FOLLOWING
    assert following.pose.yaw > math.radians(20.0)
    for _ in following.sees_nothing(9.0):
        pass
    assert following.mode is Mode.SEARCHING
    assert abs(following.pose.y) < 0.2


def test_the_cable_is_known_again_after_something_else_was_followed_for_long(following):
    for _ in following.sees_nothing(6.0):
        pass
    furrow = RememberedLine(following.pose.x, following.pose.y + 0.1, math.radians(25.0))
    for _ in range(80):
        following.sees(furrow.relative_to(following.pose))
    for _ in following.sees_nothing(3.0):
        pass
    assert following.mode is Mode.SEARCHING
    assert following.pose.y > 0.5
    following.sees_the_x_axis(1.0)
    assert following.mode is Mode.FOLLOWING


def test_a_find_that_was_followed_for_long_is_the_new_line(following):
    for _ in following.sees_nothing(4.0):
        pass
    cable = RememberedLine(following.pose.x, following.pose.y, math.radians(25.0))
    for _ in range(80):
        following.sees(cable.relative_to(following.pose))
    for _ in following.sees_nothing(9.0):
        pass
    assert following.mode is Mode.SEARCHING
    assert abs(cable.relative_to(following.pose).offset) < 0.2


def test_without_odometry_a_lost_cable_is_not_searched_for():
    trial = Trial(has_odometry=False)
    trial.sees_the_x_axis(5.0)
    for _ in trial.sees_nothing(30.0):
        pass
    assert trial.mode is Mode.STOPPED
    assert trial.command == STOP


@given(st.floats(0.0, 100.0))
def test_sweeps_keep_within_their_limit(progress):
    assert abs(sweep(progress)) <= MOST_SWEEP
    assert sweep(min(progress, STRAIGHT)) == 0.0


def test_a_clock_that_is_set_back_does_not_let_the_vehicle_go_on_blindly():
    trial = Trial()
    for _ in range(30):
        trial.sees(AHEAD)
    trial.time -= 600.0
    trial.has_odometry = False
    for _ in range(30):
        command = trial.sees(None)
    assert trial.mode is Mode.STOPPED
    assert command == STOP
