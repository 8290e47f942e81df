import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.simulation.borders import fit_states, project_tube
from cable_tracker.simulation.motion.steering import steer
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.rendering.tube import Bend, Tube

CAMERA = Camera((320, 240), 280.0, np.deg2rad(20))
STATES = st.tuples(
    st.floats(-90, 90), st.floats(-1.0, 1.0), st.floats(15, 90), st.floats(-0.02, 0.1)
)


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
