from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.example_controller.line_of_sight import (
    MOST_INTEGRAL,
    CableLine,
    GuidanceSettings,
    LineOfSight,
)

STEP = 0.1
SETTINGS = GuidanceSettings()


def offsets(least: float, most: float) -> st.SearchStrategy[float]:
    return st.floats(least, most, allow_nan=False)


def sail(aside: float, turned: float, current: float, seconds: float) -> tuple[float, float]:
    """Follow the x axis from (0, aside) through water that moves along y, without any lag.

    Return how far aside the vehicle is at the end, and its yaw.
    """
    guidance = LineOfSight(SETTINGS)
    y, yaw = aside, turned
    for _ in range(round(seconds / STEP)):
        command = guidance.steer(CableLine(-y / math.cos(yaw), -yaw), STEP)
        yaw += command.turn * STEP
        y += (command.surge * math.sin(yaw) + current) * STEP
    return y, yaw


@given(offsets(0.05, 3.0))
def test_a_cable_to_the_left_is_steered_for_by_a_turn_to_the_left(offset):
    assert LineOfSight(SETTINGS).steer(CableLine(offset, 0.0), STEP).turn > 0.0
    assert LineOfSight(SETTINGS).steer(CableLine(-offset, 0.0), STEP).turn < 0.0


@given(offsets(0.02, 1.2))
def test_a_cable_that_leads_to_the_left_is_followed_by_a_turn_to_the_left(heading):
    assert LineOfSight(SETTINGS).steer(CableLine(0.0, heading), STEP).turn > 0.0
    assert LineOfSight(SETTINGS).steer(CableLine(0.0, -heading), STEP).turn < 0.0


@given(offsets(-3.0, 3.0), offsets(-1.2, 1.2))
def test_left_and_right_are_mirror_images(offset, heading):
    one = LineOfSight(SETTINGS).steer(CableLine(offset, heading), STEP)
    other = LineOfSight(SETTINGS).steer(CableLine(-offset, -heading), STEP)
    assert one.surge == other.surge
    assert one.turn == -other.turn


@given(offsets(-50.0, 50.0), offsets(-1.5, 1.5))
def test_commands_keep_within_their_limits(offset, heading):
    command = LineOfSight(SETTINGS).steer(CableLine(offset, heading), STEP)
    assert 0.0 <= command.surge <= SETTINGS.speed
    assert abs(command.turn) <= SETTINGS.most_turn


@settings(max_examples=25)
@given(offsets(-2.0, 2.0), offsets(-1.0, 1.0))
def test_the_vehicle_comes_onto_a_straight_cable_and_stays(aside, turned):
    y, yaw = sail(aside, turned, current=0.0, seconds=120.0)
    assert abs(y) < 0.01
    assert abs(yaw) < 0.01


@settings(max_examples=25)
@given(offsets(-1.0, 1.0), offsets(-0.2, 0.2))
def test_a_current_is_steered_against_until_no_offset_is_left(aside, current):
    y, yaw = sail(aside, 0.0, current, seconds=200.0)
    assert abs(y) < 0.02
    assert math.sin(yaw) * SETTINGS.speed == pytest.approx(-current, abs=0.03)


def test_without_the_integral_a_current_leaves_an_offset():
    guidance = LineOfSight(GuidanceSettings(integral_gain=0.0))
    y, yaw = 0.0, 0.0
    for _ in range(2000):
        command = guidance.steer(CableLine(-y / math.cos(yaw), -yaw), STEP)
        yaw += command.turn * STEP
        y += (command.surge * math.sin(yaw) + 0.1) * STEP
    assert y > 0.1


@given(st.lists(offsets(-5.0, 5.0), min_size=1, max_size=100))
def test_the_integral_keeps_within_its_limit(errors):
    guidance = LineOfSight(SETTINGS)
    for error in errors:
        guidance.steer(CableLine(error, 0.0), 1.0)
        # Straight over the cable, it is the integral alone that is steered by.
        over = guidance.steer(CableLine(0.0, 0.0), 0.0)
        integral = SETTINGS.look_ahead * math.tan(math.acos(over.surge / SETTINGS.speed))
        assert integral <= MOST_INTEGRAL + 1e-9


def test_turning_comes_before_going_on():
    straight = LineOfSight(SETTINGS).steer(CableLine(0.0, 0.0), STEP)
    askew = LineOfSight(SETTINGS).steer(CableLine(0.0, 1.2), STEP)
    assert straight.surge == SETTINGS.speed
    assert askew.surge < 0.5 * SETTINGS.speed
