from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.metric.frames import rotation_of
from cable_tracker.simulation.vehicle import (
    Current,
    Vehicle,
    VehicleModel,
    VehicleState,
    VelocityCommand,
)

ALTITUDE = 2.0


def vehicle(current: float = 0.0, yaw: float = 0.0, seed: int = 1) -> Vehicle:
    rng = np.random.default_rng(seed)
    pose = np.array([0.0, 0.0, ALTITUDE, yaw])
    return Vehicle(Current.random(current, rng), pose, rng)


def run(craft: Vehicle, command: VelocityCommand, seconds: float) -> None:
    for _ in range(round(seconds / 0.1)):
        craft.advance(command, float(craft.pose[2]), 0.1)


@pytest.mark.parametrize(
    ("command", "axis"),
    [
        (VelocityCommand(surge=0.5), 0),
        (VelocityCommand(sway=0.2), 1),
        (VelocityCommand(turn=0.3), 3),
    ],
)
def test_a_velocity_is_reached_through_the_water(command, axis):
    craft = vehicle()
    run(craft, command, 15.0)
    wanted = (command.surge, command.sway, 0.0, command.turn)
    assert craft.velocity[axis] == pytest.approx(wanted[axis], rel=0.02)


def test_a_vehicle_takes_time_to_reach_a_commanded_velocity():
    craft = vehicle()
    craft.advance(VelocityCommand(surge=0.5), ALTITUDE, 0.1)
    assert 0.0 < craft.velocity[0] < 0.1


def test_forward_is_where_the_bow_points():
    craft = vehicle(yaw=math.pi / 2)
    run(craft, VelocityCommand(surge=0.5), 10.0)
    x, y = craft.pose[:2]
    assert abs(x) < 0.01
    assert y > 3.0


def test_a_turn_to_the_left_is_positive():
    craft = vehicle()
    run(craft, VelocityCommand(turn=0.2), 5.0)
    assert 0.5 < craft.pose[3] < 1.0


def test_standing_still_it_drifts_with_the_current():
    craft = vehicle(current=0.2)
    run(craft, VelocityCommand(), 20.0)
    way = float(np.hypot(*craft.pose[:2]))
    assert 3.0 - 1e-9 <= way <= 5.0
    assert np.allclose(craft.velocity[:2], 0.0)


def test_the_altitude_is_kept_and_moved_on_command():
    craft = vehicle()
    run(craft, VelocityCommand(surge=0.5), 10.0)
    assert craft.pose[2] == pytest.approx(ALTITUDE, abs=0.01)
    run(craft, VelocityCommand(heave=0.1), 5.0)
    run(craft, VelocityCommand(), 20.0)
    assert craft.pose[2] == pytest.approx(ALTITUDE + 0.5, abs=0.05)


def test_thrust_has_its_limits():
    craft = vehicle()
    run(craft, VelocityCommand(surge=50.0), 30.0)
    assert craft.velocity[0] < 1.5


def moved(before: VehicleState, after: VehicleState, seconds: float) -> np.ndarray:
    return (after.position - before.position) / seconds


def test_the_twist_is_how_the_pose_changes():
    craft = vehicle(current=0.1)
    run(craft, VelocityCommand(surge=0.5, turn=0.1), 5.0)
    command, step = VelocityCommand(surge=0.5, turn=0.1), 0.01
    before = craft.state()
    craft.advance(command, ALTITUDE, step)
    after = craft.state()
    middle = (before.twist + after.twist) / 2
    in_world = rotation_of((before.angles + after.angles) / 2) @ middle[:3]
    assert in_world == pytest.approx(moved(before, after, step), abs=2e-3)
    turned = rotation_of(before.angles).T @ rotation_of(after.angles)
    rates = np.array([turned[2, 1], turned[0, 2], turned[1, 0]]) / step
    assert middle[3:] == pytest.approx(rates, abs=2e-3)


def test_the_acceleration_is_how_the_velocity_over_ground_changes_in_a_turn_too():
    craft = vehicle()
    command, step = VelocityCommand(surge=0.5, sway=0.1, turn=0.3), 0.01
    run(craft, command, 8.0)
    motions = [craft.state()]
    for _ in range(2):
        craft.advance(command, ALTITUDE, step)
        motions.append(craft.state())
    before, now, after = motions
    first, last = (rotation_of(each.angles) @ each.twist[:3] for each in (before, after))
    gained = rotation_of(now.angles).T @ (last - first) / (2 * step)
    assert np.hypot(*gained[:2]) > 0.1
    assert now.acceleration == pytest.approx(gained, abs=5e-3)


def test_roll_and_pitch_stay_small_but_not_zero():
    craft = vehicle()
    tilts = []
    for _ in range(100):
        craft.advance(VelocityCommand(), ALTITUDE, 0.2)
        tilts.append(craft.state().angles[:2])
    assert 0.002 < np.abs(tilts).max() <= VehicleModel().tilt


def test_a_state_that_is_moved_a_little_is_where_its_vehicle_goes():
    craft = vehicle(current=0.4, yaw=0.7)
    command = VelocityCommand(surge=0.4, sway=0.1, turn=0.3)
    run(craft, command, 3.0)
    start = craft.state()
    craft.advance(command, ALTITUDE, 0.01)
    there, back = craft.state(), start.moved(0.01).moved(-0.01)
    np.testing.assert_allclose(start.moved(0.01).position, there.position, atol=1e-4)
    np.testing.assert_allclose(start.moved(0.01).angles, there.angles, atol=1e-4)
    np.testing.assert_allclose(back.position, start.position, atol=1e-4)
