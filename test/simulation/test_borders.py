import numpy as np
import pytest

from cable_tracker.simulation.borders import fit_states, project_tube, visible_share
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.rendering.tube import SETTLED, Bend, Tube

SIZE = (320, 240)


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
