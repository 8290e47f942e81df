import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.simulation.borders import fit_states, project_tube, steer, visible_share
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.rendering.laid_cable import SETTLED, Bend, Tube

SIZE = (320, 240)

CAMERA = Camera((320, 240), 280.0, np.deg2rad(20))
STATES = st.tuples(
    st.floats(-90, 90), st.floats(-1.0, 1.0), st.floats(15, 90), st.floats(-0.02, 0.1)
)


def _look(tube, camera, *, x=0.0, z=2.0, yaw=0.0, pitch=0.0):
    poses = camera.poses(np.array([[x, 0.0, z]]), np.array([[0.0, -pitch, yaw]]))
    projected = project_tube(tube, camera, poses)
    return projected, fit_states(projected, camera.image_size)[0]


def _width(focal, radius, altitude):
    """A line of sight that touches a tube from straight above has the slope r / sqrt(h² - r²)."""
    height = altitude - SETTLED * radius
    return 2 * focal * radius / np.sqrt(height**2 - radius**2)


def test_a_straight_cable_from_straight_above():
    _, state = _look(Tube(0.1), Camera(SIZE, 280.0))
    assert state[:4] == pytest.approx((0.0, 0.0, _width(280.0, 0.1, 2.0), 0.0), abs=1e-9)


def test_a_vehicle_that_turns_left_sees_the_cable_turned_right():
    _, state = _look(Tube(0.1), Camera(SIZE, 280.0), yaw=0.3)
    assert state[:4] == pytest.approx((0.0, -0.3, _width(280.0, 0.1, 2.0), 0.0), abs=1e-9)


def test_a_vehicle_to_the_right_sees_the_cable_on_the_left():
    """The tangents from (0.5, h) to the circle of radius r around the axis."""
    _, state = _look(Tube(0.1), Camera(SIZE, 280.0), x=0.5)
    height = 2.0 - SETTLED * 0.1
    middle = np.arctan2(0.5, height)
    half = np.arcsin(0.1 / np.hypot(0.5, height))
    left, right = -280 * np.tan(middle + half), -280 * np.tan(middle - half)
    assert state[0] == pytest.approx((left + right) / 2, abs=1e-9)
    assert state[2] == pytest.approx(right - left, abs=1e-9)


def test_borders_meet_at_the_vanishing_point_of_a_pitched_camera():
    """The horizon lies f / tan(pitch) above the image centre."""
    pitch = np.deg2rad(35)
    _, state = _look(Tube(0.1), Camera(SIZE, 280.0), pitch=pitch)
    assert state[0] == pytest.approx(0.0, abs=1e-9)
    assert state[2] / 2 / np.tan(state[3]) == pytest.approx(280 / np.tan(pitch), rel=1e-9)


def test_a_gentle_bend_stays_near_the_fitted_line():
    tube = Tube(0.08, (Bend(0.08, 0.4, 0.7),))
    projected, state = _look(tube, Camera(SIZE, 280.0), z=1.2, pitch=0.4)
    points = projected.points[0][projected.inside[0]]
    angles = np.repeat((state[1] - state[3], state[1] + state[3]), projected.inside[0].sum(axis=1))
    centre = points[:, 0] * np.cos(angles) + points[:, 1] * np.sin(angles)
    sides = np.repeat((-1.0, 1.0), projected.inside[0].sum(axis=1))
    borders = (state[0] + sides * state[2] / 2) * np.cos(state[3])
    assert np.abs(centre - borders).max() < 1.5


def test_a_cable_outside_the_image_is_not_in_view():
    projected, state = _look(Tube(0.1), Camera(SIZE, 280.0), x=2.0)
    assert not projected.in_view().any()
    assert np.isfinite(state).all()
    assert state[0] < -200


def test_a_camera_that_looks_away_has_no_state():
    _, state = _look(Tube(0.1), Camera(SIZE, 280.0), pitch=np.pi)
    assert np.isnan(state).all()


@pytest.mark.parametrize("covered", [False, True])
def test_visibility_of_a_free_and_of_a_covered_cable(covered):
    projected, _ = _look(Tube(0.1), Camera(SIZE, 280.0))
    hidden = np.full(projected.inside.shape[1:], covered)
    assert visible_share(projected, 0, hidden) == (0.0 if covered else 1.0)


def test_one_covered_border_is_half_of_the_visibility():
    projected, _ = _look(Tube(0.1), Camera(SIZE, 280.0))
    hidden = np.zeros(projected.inside.shape[1:], dtype=bool)
    hidden[0] = True
    assert visible_share(projected, 0, hidden) == pytest.approx(0.5, abs=0.02)


def test_visibility_without_a_border_in_the_image_is_none():
    projected, _ = _look(Tube(0.1), Camera(SIZE, 280.0), x=2.0)
    assert visible_share(projected, 0, np.zeros(projected.inside.shape[1:], dtype=bool)) == 0.0


def _steer(tube, camera, state, roll=0.0, travel=0.0):
    states = np.zeros((1, 8))
    states[0, :4] = state
    poses = steer(tube, camera, states, np.array([roll]), np.array([travel]))
    return poses, fit_states(project_tube(tube, camera, poses), camera.image_size)[0]


@given(STATES, st.floats(-0.1, 0.1), st.floats(-100, 100))
def test_the_vehicle_sees_what_it_was_steered_for(state, roll, travel):
    poses, seen = _steer(Tube(0.08), CAMERA, state, roll, travel)
    np.testing.assert_allclose(seen[:4], state, atol=1e-6)
    assert poses.positions[0, 1] == pytest.approx(travel, abs=1e-6)
    assert np.linalg.det(poses.rotations[0]) == pytest.approx(1.0)
    assert poses.rotations[0, 2, 0] == pytest.approx(-np.sin(roll), abs=1e-9)


@settings(max_examples=25)
@given(STATES, st.floats(0.0, 50.0))
def test_bends_and_distortion_are_taken_into_account(state, travel):
    tube = Tube(0.08, (Bend(0.07, 0.4, 0.3),))
    camera = Camera((320, 240), 280.0, 0.3, (-0.1, 0.02, 0.0, 0.0, 0.0))
    _, seen = _steer(tube, camera, state, travel=travel)
    np.testing.assert_allclose(seen[[0, 2]], [state[0], state[2]], atol=0.15)
    np.testing.assert_allclose(seen[[1, 3]], [state[1], state[3]], atol=3e-3)


def test_altitude_is_in_proportion_to_the_cable_and_inverse_to_its_width():
    wide, _ = _steer(Tube(0.08), CAMERA, (0.0, 0.0, 40.0, 0.0))
    narrow, _ = _steer(Tube(0.08), CAMERA, (0.0, 0.0, 20.0, 0.0))
    height = Tube(0.08).height
    ratio = (narrow.positions[0, 2] - height) / (wide.positions[0, 2] - height)
    assert ratio == pytest.approx(2.0, rel=0.01)


def test_a_skew_of_nought_is_a_camera_that_looks_straight_down():
    poses, _ = _steer(Tube(0.08), CAMERA, (0.0, 0.0, 40.0, 0.0))
    np.testing.assert_allclose(poses.rotations[0], np.eye(3), atol=1e-12)
    assert CAMERA.vehicle_angles(poses)[0, 1] == pytest.approx(CAMERA.mounting)
