from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.errors import ParameterError
from cable_tracker.simulation.cable_scene import cable_course
from cable_tracker.simulation.live_world import LiveSettings, LiveWorld
from cable_tracker.simulation.vehicle import VehicleState, VelocityCommand

SMALL = LiveSettings(seed=3, length=20.0, buried=5.0, image_width=64, image_height=48)


@pytest.fixture(scope="module")
def world() -> LiveWorld:
    return LiveWorld(SMALL)


def over_the_cable(world: LiveWorld, along: float, aside: float = 0.0, turned: float = 0.0):
    """Put the vehicle to the left of the cable, turned to the left of it."""
    point, direction = (part[0] for part in world.cable_at(np.array([along])))
    course = math.atan2(direction[1], direction[0])
    place = point + aside * np.array([-math.sin(course), math.cos(course), 0.0])
    return VehicleState(
        position=np.array([place[0], place[1], SMALL.altitude]),
        angles=np.array([0.0, 0.0, course + turned]),
        twist=np.zeros(6),
        acceleration=np.zeros(3),
    )


@pytest.mark.parametrize(
    "change",
    [
        {"length": 0.0},
        {"buried": 30.0},
        {"altitude": 0.0},
        {"current": -1.0},
        {"rate": 0.0},
        {"seed": -1},
        {"image_width": 8},
        {"image_height": 8},
    ],
)
def test_values_out_of_their_range_are_refused(change):
    with pytest.raises(ParameterError):
        LiveSettings(**{"length": 20.0, **change})


@pytest.mark.parametrize("aside", [-0.5, 0.0, 0.4])
@pytest.mark.parametrize("turned", [-0.3, 0.0, 0.2, 1.8, -2.5])
def test_the_truth_is_where_the_vehicle_was_put(world, aside, turned):
    truth = world.cross_track(over_the_cable(world, 4.0, aside, turned))
    assert truth.along == pytest.approx(4.0, abs=1e-6)
    assert truth.error == pytest.approx(-aside, abs=1e-9)
    assert truth.heading == pytest.approx(-turned, abs=1e-9)
    assert truth.offset == pytest.approx(-aside / math.cos(turned), abs=1e-9)


def test_a_cable_to_the_left_is_in_the_left_half_of_the_image(world):
    left = world.true_state(over_the_cable(world, 3.0, aside=-0.4))
    right = world.true_state(over_the_cable(world, 3.0, aside=0.4))
    assert left.distance < 0.0 < right.distance


def test_a_vehicle_turned_to_the_left_sees_the_cable_lead_to_the_right(world):
    # The top of the cable leans right: alpha is negative.
    assert world.true_state(over_the_cable(world, 3.0, turned=0.3)).angle < -0.2


@pytest.mark.parametrize("turned", [0.0, *np.linspace(1.3, 1.8, 6)])
def test_a_turning_vehicle_sees_the_cable_turn_the_other_way(world, turned):
    state = replace(
        over_the_cable(world, 3.0, turned=turned), twist=np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.4])
    )
    assert world.true_state(state).angle_rate == pytest.approx(-0.4, abs=0.1)


def test_a_vehicle_that_hovers_sees_the_cable_rest(world):
    rates = world.true_state(over_the_cable(world, 3.0)).to_array()[4:]
    assert rates == pytest.approx(np.zeros(4), abs=1e-9)


def test_under_the_sand_nothing_is_to_be_seen(world):
    assert world.true_state(over_the_cable(world, 9.2)) is None
    assert world.true_state(over_the_cable(world, 16.0)) is not None


def test_the_vehicle_starts_where_it_sees_the_cable(world):
    assert world.true_state(LiveWorld(SMALL).state()) is not None


def test_the_course_can_be_had_without_the_world(world):
    along = np.linspace(0.0, 20.0, 7)
    assert np.array_equal(cable_course(SMALL.seed, along), world.cable_at(along)[0])


def test_the_same_seed_gives_the_same_pictures():
    pictures = []
    for _ in range(2):
        own = LiveWorld(SMALL)
        own.advance(VelocityCommand(surge=0.4), SMALL.altitude, 0.5)
        pictures.append(own.picture(own.state()))
    assert np.array_equal(*pictures)
    other = LiveWorld(LiveSettings(seed=4, length=20.0, image_width=64, image_height=48))
    assert not np.array_equal(pictures[0], other.picture(other.state()))
