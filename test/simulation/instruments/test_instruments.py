from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.simulation.instruments.instruments import (
    GRAVITY,
    InstrumentErrors,
    InstrumentSet,
)
from cable_tracker.simulation.vehicle import VehicleState

PERFECT = InstrumentErrors(*[0.0] * 8)


def state(x: float = 0.0) -> VehicleState:
    return VehicleState(
        position=np.array([x, 0.0, 2.0]),
        angles=np.zeros(3),
        twist=np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.1]),
        acceleration=np.zeros(3),
    )


def instruments(errors: InstrumentErrors, seed: int = 0) -> InstrumentSet:
    return InstrumentSet(errors, state(), np.random.default_rng(seed))


def test_perfect_instruments_say_what_is():
    perfect = instruments(PERFECT)
    reading = perfect.odometry(state(), 0.0)
    assert np.array_equal(reading.twist, state().twist)
    assert perfect.altitude(state()) == 2.0
    assert perfect.imu(state()).acceleration == pytest.approx([0.0, 0.0, GRAVITY])


def test_odometry_adds_the_way_up():
    perfect = instruments(PERFECT)
    perfect.odometry(state(), 0.0)
    for _ in range(10):
        reading = perfect.odometry(state(), 0.2)
    assert reading.position == pytest.approx([1.0, 0.0, 2.0])


def test_errors_are_of_the_size_that_the_covariance_states():
    errors = InstrumentErrors()
    wrong = []
    for seed in range(200):
        reading = instruments(errors, seed).odometry(state(), 0.0)
        wrong.append(reading.twist - state().twist)
    assert np.std(wrong, axis=0) == pytest.approx(
        np.sqrt(np.diag(reading.twist_covariance)), rel=0.2
    )


def test_doubt_about_the_place_grows():
    real = instruments(InstrumentErrors())
    first = real.odometry(state(), 0.0).pose_covariance[0, 0]
    for _ in range(100):
        last = real.odometry(state(), 0.1).pose_covariance[0, 0]
    assert last > first


def test_a_scale_error_stretches_the_velocities_and_not_the_turn():
    stretched = instruments(replace(PERFECT, velocity_scale=0.1))
    twists = [stretched.odometry(state(), 0.1).twist for _ in range(2)]
    assert np.array_equal(*twists)
    assert twists[0][0] != state().twist[0]
    assert np.array_equal(twists[0][3:], state().twist[3:])
