from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cable_tracker.cable.model.geometry import states_in_chart
from cable_tracker.metric.calibration import Calibration, CameraModel
from cable_tracker.metric.frames import Attitude, Mounting, rotations_of
from cable_tracker.metric.ground_view import (
    GroundView,
    PlaneMotion,
    homography,
    move_states,
    prediction_covariance,
)
from cable_tracker.metric.odometry.motion import PoseChange, rotations_by

CAMERA = CameraModel(Calibration((320, 240), "plumb_bob", (300.0, 300.0), (159.5, 119.5)))

DEGREE = math.pi / 180
STATES = np.array([[20.0, 0.1, 40.0, 0.03], [-60.0, 1.5, 25.0, -0.02], [0.0, -1.5, 60.0, 0.0]])


def test_a_camera_that_looks_straight_down_sees_by_similar_triangles():
    view = GroundView(CAMERA, Mounting(x=0.5, z=-0.25), Attitude(), 1.75, 0.02)
    ground = view.on_ground(np.array([[0.0, 0.0], [30.0, 0.0], [0.0, 60.0]]))
    assert ground == pytest.approx(np.array([[0.5, 0.0], [0.5, -0.15], [0.8, 0.0]]))


def test_at_and_above_the_horizon_there_is_no_ground():
    view = GroundView(CAMERA, Mounting(pitch=math.radians(10.0)), Attitude(), 2.0, 0.02)
    horizon = 300.0 * math.tan(math.radians(10.0))
    ground = view.on_ground(np.array([[0.0, horizon - 1.0], [0.0, horizon + 1.0]]))
    assert ground[0, 0] > 100.0
    assert np.isnan(ground[1]).all()


@pytest.mark.parametrize("height", [0.0, -0.5])
def test_a_camera_that_is_no_higher_than_the_cable_sees_no_ground(height):
    view = GroundView(CAMERA, Mounting(), Attitude(), height, 0.02)
    assert np.isnan(view.on_ground(np.array([[0.0, 0.0], [30.0, -60.0]]))).all()


def change_of(translation, turn, covariance=None, seconds=0.04) -> PoseChange:
    unsure = np.zeros((6, 6)) if covariance is None else covariance
    return PoseChange(rotations_by(np.array([turn]))[0], np.array(translation), unsure, seconds)


@pytest.fixture
def ground_view(calibrations, camera_of, make_flight):
    flight = make_flight()
    camera = camera_of(calibrations["pinhole"])
    return GroundView(camera, flight.mounting, Attitude(0.03, -0.05), 1.4, 0.02)


def test_without_motion_nothing_moves(ground_view):
    mapping = homography(ground_view, change_of([0, 0, 0], [0, 0, 0]))
    np.testing.assert_allclose(mapping, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(move_states(STATES, mapping), STATES, atol=1e-9)


@settings(
    max_examples=12,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    shift=st.tuples(*[st.floats(-0.08, 0.08)] * 3),
    turn=st.tuples(*[st.floats(-3 * DEGREE, 3 * DEGREE)] * 3),
)
def test_a_cable_moves_as_the_camera_sees_it_move(
    make_flight, camera_of, calibrations, shift, turn
):
    """The later view is made from the pose, not by the homography."""
    camera = camera_of(calibrations["pinhole"])
    before = make_flight(0.1, 0.15, attitude=Attitude(0.02, -0.04))
    change = change_of(shift, turn)
    level = rotations_of(np.array([[0.02, -0.04, 0.0]]))[0]
    # The vehicle turns and moves; the level frame of before stays the frame of the cable.
    later = _Later(before, level @ change.rotation, level @ change.translation)
    view = GroundView(camera, before.mounting, before.attitude, before.altitude.metres, 0.0)
    moved = move_states(before.seen_by(camera).to_array()[None, :], homography(view, change))
    expected = later.seen_by(camera).to_array()[None, :]
    chart = states_in_chart(expected, float(moved[0, 1]))[0, :4]
    assert (np.abs(moved[0] - chart) < [0.15, 2e-3, 0.15, 1e-3]).all()


class _Later:
    """The same cable, from where the vehicle is then."""

    def __init__(self, before, rotation, translation):
        self._before, self._rotation, self._translation = before, rotation, translation

    def seen_by(self, camera):
        flight = self._before

        class Seen(type(flight)):
            def to_optical(inner, points):
                in_vehicle = (points - self._translation) @ self._rotation
                return (in_vehicle - flight.mounting.position) @ flight.mounting.rotation

        fields = {f.name: getattr(flight, f.name) for f in dataclasses.fields(flight)}
        return Seen(**fields).seen_by(camera)


def test_there_and_back_is_where_it_was(ground_view):
    forth = change_of([0.05, 0.02, -0.01], [0.01, -0.02, 0.03])
    mapping = homography(ground_view, forth)
    moved = move_states(STATES, mapping)
    np.testing.assert_allclose(move_states(moved, np.linalg.inv(mapping)), STATES, atol=1e-9)


def test_an_angle_goes_on_across_the_wrap(ground_view):
    moved = move_states(STATES, homography(ground_view, change_of([0, 0, 0], [0, 0, 0.1])))
    # A vehicle that turns to the left sees the cable turn to the right, also beyond pi/2.
    assert (moved[:, 1] < STATES[:, 1]).all()
    assert np.abs(moved[:, 1] - STATES[:, 1]).max() < 0.2


class TestPredictionCovariance:
    def spread(self, ground_view, covariance, height_sigma=0.0, translation=(0.02, 0.05, 0.0)):
        view = dataclasses.replace(ground_view, height_sigma=height_sigma)
        return prediction_covariance(STATES[0], view, change_of(translation, [0, 0, 0], covariance))

    def test_it_agrees_with_monte_carlo(self, ground_view):
        covariance = np.diag([0.01, 0.02, 0.01, 0.01, 0.01, 0.02]) ** 2
        spread = self.spread(ground_view, covariance, height_sigma=0.1)
        rng = np.random.default_rng(3)
        moved = []
        for noise in rng.standard_normal((800, 7)):
            errors = noise[:6] * np.sqrt(np.diag(covariance))
            change = change_of(np.array([0.02, 0.05, 0.0]) + errors[:3], errors[3:])
            view = dataclasses.replace(ground_view, height=1.4 + 0.1 * noise[6])
            moved.append(move_states(STATES[:1], homography(view, change))[0])
        np.testing.assert_allclose(
            np.sqrt(np.diag(spread)), np.std(moved, axis=0), rtol=0.1, atol=1e-4
        )

    def test_sure_odometry_leaves_nothing_unknown(self, ground_view):
        assert np.abs(self.spread(ground_view, np.zeros((6, 6)))).max() < 1e-12

    def test_an_unsure_altitude_leaves_the_motion_unsure(self, ground_view):
        unsure = self.spread(ground_view, np.zeros((6, 6)), height_sigma=0.3)
        still = self.spread(ground_view, np.zeros((6, 6)), height_sigma=0.3, translation=(0, 0, 0))
        assert unsure[0, 0] > 0.1 > still[0, 0]

    def test_an_unsure_sway_is_one_of_d(self, ground_view):
        spread = self.spread(ground_view, np.diag([0, 0.01, 0, 0, 0, 0]) ** 2)
        assert 1.0 < math.sqrt(spread[0, 0]) < 280.0 * 0.01 / 1.0
        assert math.sqrt(spread[1, 1]) < 1.0 * DEGREE


def test_the_aid_of_the_filters_gives_rates_and_their_doubt(ground_view):
    mapping = homography(ground_view, change_of([0.0, 0.05, 0.0], [0, 0, 0.01]))
    aid = PlaneMotion(mapping, 0.1, np.array([0.5, 0.01, 0.4, 0.002]))
    states = np.hstack((STATES, np.ones_like(STATES)))
    moved = aid.moved(states)
    assert moved.shape == (3, 8)
    np.testing.assert_allclose(moved[:, :4] - STATES, 0.1 * moved[:, 4:])
    np.testing.assert_allclose(aid.scales(), [0.5, 0.01, 0.4, 0.002, 5.0, 0.1, 4.0, 0.02])


def test_a_camera_in_the_ground_has_still_a_homography(ground_view):
    low = dataclasses.replace(ground_view, height=-3.0)
    assert np.isfinite(homography(low, change_of([0.1, 0.0, 0.0], [0, 0, 0]))).all()
