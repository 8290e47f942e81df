from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.metric.odometry.motion import (
    FROZEN_COUNT,
    Odometry,
    PoseChange,
    Unaided,
    moved_between,
    rotations_by,
)
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE

SECOND = 1_000_000_000
STEP, FRAME = SECOND // 50, SECOND // 25
COVARIANCE = np.diag([1e-4, 1e-4, 4e-4, 1e-5, 1e-5, 1e-6])
VECTORS = arrays(np.float64, 3, elements=st.floats(-1.5, 1.5))


def odometry(twist, count=20, start=10 * SECOND, step=STEP, wobble=1e-6) -> Odometry:
    """Twists that are constant but for a wobble: an instrument that lives."""
    source = Odometry()
    for index in range(count):
        own = np.array(twist, dtype=np.float64) + wobble * (-1) ** index
        source.add(start + index * step, own, COVARIANCE)
    return source


def moved(source, start, end) -> PoseChange:
    change = source.motion(start, end)
    assert isinstance(change, PoseChange), change
    return change


def why(source, start, end) -> str:
    unknown = source.motion(start, end)
    assert isinstance(unknown, Unaided)
    return unknown.why


def test_a_velocity_is_covered_in_its_time():
    change = moved(odometry([0.5, -0.2, 0.1, 0, 0, 0]), 10 * SECOND, 10 * SECOND + 2 * STEP)
    np.testing.assert_allclose(change.translation, np.array([0.5, -0.2, 0.1]) * 0.04, atol=1e-6)
    np.testing.assert_allclose(change.rotation, np.eye(3), atol=1e-6)
    assert change.seconds == pytest.approx(0.04)


def test_a_turn_to_the_left_bends_the_way_to_the_left():
    # A quarter of a circle of radius 1 m in 0.3 s.
    rate = math.pi / 2 / 0.3
    change = moved(odometry([rate, 0, 0, 0, 0, rate]), 10 * SECOND, 10 * SECOND + 15 * STEP)
    np.testing.assert_allclose(change.translation, [1.0, 1.0, 0.0], atol=5e-3)
    np.testing.assert_allclose(change.rotation @ [1, 0, 0], [0, 1, 0], atol=1e-3)


def test_twists_are_interpolated_between_their_stamps():
    source = Odometry()
    for index, speed in enumerate((0.0, 1.0)):
        source.add(10 * SECOND + index * STEP, np.array([speed, 0, 0, 0, 0, 0]), COVARIANCE)
    change = moved(source, 10 * SECOND, 10 * SECOND + STEP // 2)
    assert change.translation[0] == pytest.approx(0.25 * 0.01)


@given(st.integers(1, 17))
def test_the_way_in_two_parts_is_the_way_in_one(parts):
    source = odometry([0.4, 0.1, -0.2, 0.1, -0.3, 0.5])
    start, middle, end = 10 * SECOND, 10 * SECOND + parts * STEP, 10 * SECOND + 18 * STEP
    first, second, whole = (
        moved(source, *times) for times in ((start, middle), (middle, end), (start, end))
    )
    joined = first.translation + first.rotation @ second.translation
    np.testing.assert_allclose(joined, whole.translation, atol=1e-12)
    np.testing.assert_allclose(first.rotation @ second.rotation, whole.rotation, atol=1e-12)


def test_doubt_grows_with_the_way():
    source = odometry([0.1, 0, 0, 0, 0, 0])
    for steps in (1, 4):
        change = moved(source, 10 * SECOND, 10 * SECOND + steps * STEP)
        np.testing.assert_allclose(change.covariance, COVARIANCE * (steps * 0.02) ** 2)


def test_the_last_twist_is_held_for_a_moment_and_no_longer():
    source = odometry([0.1, 0, 0, 0, 0, 0], count=5)
    last = 10 * SECOND + 4 * STEP
    assert moved(source, last, last + STEP).translation[0] == pytest.approx(0.002, rel=1e-3)
    assert "older than the image" in why(source, last, last + SECOND)


def test_over_a_long_silence_nothing_is_interpolated():
    source = odometry([0.1, 0, 0, 0, 0, 0])
    source.add(20 * SECOND, np.array([-0.1, 0, 0, 0, 0, 0]), COVARIANCE)
    assert "from the image" in why(source, 15 * SECOND, 15 * SECOND + STEP)


def test_odometry_of_the_future_is_of_no_use():
    assert "later stamps" in why(odometry([0] * 6), 9 * SECOND, 9 * SECOND + STEP)


def test_without_odometry_nothing_is_known():
    assert why(Odometry(), 0, STEP) == "no odometry has come"


def test_odometry_that_hangs_is_noticed():
    still = odometry([0.1, 0, 0, 0, 0, 0], count=FROZEN_COUNT + 2, wobble=0.0)
    assert "again and again" in why(still, 10 * SECOND, 10 * SECOND + (FROZEN_COUNT + 1) * STEP)
    assert moved(still, 10 * SECOND, 10 * SECOND + 2 * STEP).seconds > 0.0


def test_odometry_that_is_no_number_is_refused():
    source = odometry([0.1, 0, 0, 0, 0, 0], count=3)
    source.add(10 * SECOND + 3 * STEP, np.full(6, math.nan), COVARIANCE)
    assert "not finite" in why(source, 10 * SECOND + 2 * STEP, 10 * SECOND + 3 * STEP)


@pytest.mark.parametrize(
    ("number", "doubt"), [(1e200, 1e-4), (0.1, np.finfo(float).max), (-1e300, 1e300)]
)
def test_numbers_that_are_as_good_as_infinite_are_refused(number, doubt):
    source = odometry([0.1, 0, 0, 0, 0, 0], count=3)
    for index in (3, 4):
        twist = np.full(6, number) * (1.0 + 1e-6 * index)
        source.add(10 * SECOND + index * STEP, twist, doubt * np.eye(6))
    assert "infinite" in why(source, 10 * SECOND + 3 * STEP, 10 * SECOND + 4 * STEP)


@pytest.mark.parametrize("end", [10 * SECOND, 9 * SECOND, 20 * SECOND])
def test_a_time_that_cannot_be_bridged(end):
    assert "not bridged" in why(odometry([0.1, 0, 0, 0, 0, 0]), 10 * SECOND, end)


@given(VECTORS)
def test_a_rotation_turns_about_its_vector(vector):
    rotation = rotations_by(vector[None])[0]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(rotation @ vector, vector, atol=1e-9)
    assert np.trace(rotation) == pytest.approx(1 + 2 * math.cos(np.linalg.norm(vector)), abs=1e-9)


class Vehicle:
    """Odometry and gyroscope of a vehicle."""

    def __init__(self):
        self.odometry, self.gyroscope = Odometry(), Odometry("imu")

    def between(self, start, end):
        return moved_between(self.odometry, self.gyroscope, start, end)


class TestMovedBetween:
    def test_odometry_counts_before_a_gyroscope(self):
        vehicle = Vehicle()
        assert isinstance(vehicle.between(0, FRAME), Unaided)
        for stamp in range(0, 3 * FRAME, FRAME):
            vehicle.gyroscope.add_turn(stamp, np.array([0.0, 0.0, 0.5 + 1e-9 * stamp]))
        turned = vehicle.between(0, FRAME)
        assert not isinstance(turned, Unaided) and not turned.has_translation
        assert turned.rotation[1, 0] == pytest.approx(0.5 * 0.04, rel=0.1)
        for stamp in range(0, 3 * FRAME, FRAME):
            vehicle.odometry.add(
                stamp, np.array([1.0 + 1e-9 * stamp, 0.0, 0.0, 0.0, 0.0, 0.0]), np.eye(6)
            )
        moved = vehicle.between(0, FRAME)
        assert not isinstance(moved, Unaided) and moved.has_translation
        assert moved.translation[0] == pytest.approx(0.04, rel=0.1)

    @staticmethod
    def with_odometry(*, way=1e-4, turn=1e-4, angular=0.0):
        """Odometry at 1 m/s ahead, with a variance of velocities and one of rates of turn."""
        vehicle, covariance = Vehicle(), np.diag([way] * 3 + [turn] * 3)
        for stamp in range(0, 3 * FRAME, FRAME):
            twist = np.array([1.0 + 1e-9 * stamp, 0.0, 0.0, 0.0, 0.0, angular])
            vehicle.odometry.add(stamp, twist, covariance)
        return vehicle

    @staticmethod
    def turns(vehicle):
        for stamp in range(0, 3 * FRAME, FRAME):
            vehicle.gyroscope.add_turn(stamp, np.array([0.0, 0.0, 0.5 + 1e-9 * stamp]))

    @pytest.mark.parametrize("variance", [100.0, UNKNOWN_VARIANCE])
    def test_a_gyroscope_turns_where_odometry_does_not_know_the_turn(self, variance):
        vehicle = self.with_odometry(turn=variance)
        self.turns(vehicle)
        moved = vehicle.between(0, FRAME)
        assert not isinstance(moved, Unaided) and moved.has_translation
        assert moved.rotation[1, 0] == pytest.approx(0.5 * 0.04, rel=0.1)
        assert moved.translation[0] == pytest.approx(0.04, rel=0.1)
        assert np.diag(moved.covariance).max() < 1.0

    def test_a_way_bends_as_the_gyroscope_says(self):
        # Odometry says that it turns the other way, and that it does not know.
        vehicle = self.with_odometry(turn=UNKNOWN_VARIANCE, angular=-3.0)
        for stamp in range(0, 3 * FRAME, FRAME // 4):
            vehicle.gyroscope.add_turn(stamp, np.array([0.0, 0.0, 3.0 + 1e-12 * stamp]))
        change = vehicle.between(0, 2 * FRAME)
        assert change.has_translation
        angle = 3.0 * 2 * FRAME / 1e9
        radius = (1.0 + 1e-9 * FRAME) / 3.0
        circle = [radius * math.sin(angle), radius * (1.0 - math.cos(angle)), 0.0]
        np.testing.assert_allclose(change.translation, circle, atol=1e-3)
        np.testing.assert_allclose(change.rotation @ [1, 0, 0], [
            math.cos(angle), math.sin(angle), 0.0,
        ], atol=1e-3)  # fmt: skip
        assert change.seconds == pytest.approx(2 * FRAME / 1e9)

    def test_a_gyroscope_counts_where_odometry_knows_nothing(self):
        vehicle = self.with_odometry(way=UNKNOWN_VARIANCE, turn=UNKNOWN_VARIANCE)
        self.turns(vehicle)
        turned = vehicle.between(0, FRAME)
        assert not isinstance(turned, Unaided) and not turned.has_translation
        assert turned.rotation[1, 0] == pytest.approx(0.5 * 0.04, rel=0.1)

    def test_odometry_that_does_not_know_its_way_tells_its_turn(self):
        turned = self.with_odometry(way=UNKNOWN_VARIANCE, angular=0.5).between(0, FRAME)
        assert not isinstance(turned, Unaided) and not turned.has_translation
        assert turned.rotation[1, 0] == pytest.approx(0.5 * 0.04, rel=0.1)

    def test_odometry_in_a_plane_tells_its_yaw_where_there_is_no_gyroscope(self):
        vehicle, rates = Vehicle(), np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.5])
        known = np.diag([*[1e-4] * 3, UNKNOWN_VARIANCE, UNKNOWN_VARIANCE, 1e-4])
        for stamp in range(0, 3 * FRAME, FRAME):
            vehicle.odometry.add(stamp, rates + 1e-9 * stamp, known)
        turned = vehicle.between(0, FRAME)
        assert not isinstance(turned, Unaided)
        assert turned.rotation[1, 0] == pytest.approx(0.5 * 0.04, rel=0.1)

    def test_a_turn_that_no_instrument_knows_is_told_with_the_reason(self):
        vehicle = self.with_odometry(turn=UNKNOWN_VARIANCE)
        unknown = vehicle.between(0, FRAME)
        assert isinstance(unknown, Unaided)
        assert "covariance" in unknown.why
        vehicle.gyroscope.add_turn(-9 * FRAME, np.ones(3))
        late = vehicle.between(0, FRAME)
        assert isinstance(late, Unaided)
        assert late.why.startswith("the last imu is more than")

    def test_an_instrument_that_has_come_says_why_nothing_is_known(self):
        late, without_imu, without_odometry = 10 * FRAME, Vehicle(), Vehicle()
        without_imu.odometry.add(0, np.ones(6), np.eye(6))
        without_odometry.gyroscope.add_turn(0, np.ones(3))
        for vehicle, instrument in ((without_imu, "odometry"), (without_odometry, "imu")):
            unknown = vehicle.between(late, late + FRAME)
            assert isinstance(unknown, Unaided)
            assert unknown.why.startswith(f"the last {instrument} is more than")
