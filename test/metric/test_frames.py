import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import MetricError
from cable_tracker.metric.cable_instrument_fusion import metric_settings
from cable_tracker.metric.frames import (
    Attitude,
    Mounting,
    camera_parameters,
    mounting_of,
    roll_and_pitch,
    rotation_in_plane,
    rotation_of,
    rotations_of,
)
from cable_tracker.node_parameter_tables import CableVehicleParameters, TargetVehicleParameters

ANGLES = st.floats(-1.5, 1.5)

angles = st.floats(-math.pi, math.pi)


def test_straight_down_has_the_top_of_the_image_in_front():
    right, bottom, sight = Mounting().rotation.T
    np.testing.assert_allclose(right, [0.0, -1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(bottom, [-1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(sight, [0.0, 0.0, -1.0], atol=1e-12)


def test_a_pitch_of_zero_looks_ahead():
    np.testing.assert_allclose(Mounting(pitch=0.0).rotation[:, 2], [1.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("name", ["x", "y", "z", "roll", "pitch", "yaw"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_mounting_of_what_is_no_number_is_refused(name, value):
    with pytest.raises(MetricError, match=f"the camera's {name} is {value}"):
        Mounting(**{name: value})


def test_a_positive_yaw_turns_the_view_to_the_left():
    assert Mounting(pitch=0.5, yaw=0.3).rotation[1, 2] > 0.0


def test_a_positive_roll_lowers_the_right_side():
    turned = rotations_of(np.array([[0.2, 0.0, 0.0]]))[0]
    assert (turned @ [0.0, -1.0, 0.0])[2] == pytest.approx(-math.sin(0.2))


def test_a_positive_pitch_lowers_the_front():
    turned = rotations_of(np.array([[0.0, 0.2, 0.0]]))[0]
    assert (turned @ [1.0, 0.0, 0.0])[2] == pytest.approx(-math.sin(0.2))


@given(ANGLES, ANGLES, ANGLES)
def test_rotations_keep_lengths_and_handedness(roll, pitch, yaw):
    rotation = rotations_of(np.array([[roll, pitch, yaw]]))[0]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


@given(ANGLES, ANGLES, ANGLES)
def test_roll_and_pitch_of_a_quaternion_do_not_mind_the_heading(roll, pitch, yaw):
    def about(axis, angle):
        return np.array([*(math.sin(angle / 2) * np.eye(3)[axis]), math.cos(angle / 2)])

    def product(a, b):
        (ax, ay, az, aw), (bx, by, bz, bw) = a, b
        return np.array([
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ])  # fmt: skip

    quaternion = product(product(about(2, yaw), about(1, pitch)), about(0, roll))
    assert roll_and_pitch(*quaternion) == pytest.approx((roll, pitch), abs=1e-6)


def test_an_attitude_knows_whether_it_is_one():
    assert Attitude(0.1, 0.2, 0.01).is_finite()
    assert not Attitude(math.nan).is_finite()
    assert not Attitude(sigma=-1.0).is_finite()


def test_a_rotation_by_yaw_alone_is_one_in_the_plane():
    turned = rotation_of(np.array([0.0, 0.0, 0.4]))
    np.testing.assert_allclose(turned[:2, :2], rotation_in_plane(0.4), atol=1e-15)
    np.testing.assert_array_equal(turned[2], [0.0, 0.0, 1.0])
    assert rotation_in_plane(0.4) @ [1.0, 0.0] == pytest.approx([np.cos(0.4), np.sin(0.4)])


@given(roll=angles, pitch=st.floats(-1.5, 1.5), yaw=angles)
def test_a_mounting_from_tf_looks_where_the_camera_looks(roll, pitch, yaw):
    rotation = Mounting(roll=roll, pitch=pitch, yaw=yaw).rotation
    values = camera_parameters(rotation, np.array([0.1, -0.2, 0.3]))
    mounting = metric_settings(CableVehicleParameters(**values)).mounting
    np.testing.assert_allclose(mounting.rotation, rotation, atol=1e-6)
    np.testing.assert_allclose(mounting.position, [0.1, -0.2, 0.3])


@given(yaw=angles)
def test_straight_down_has_a_mounting_too(yaw):
    rotation = Mounting(pitch=math.pi / 2, yaw=yaw).rotation
    parameters = CableVehicleParameters(**camera_parameters(rotation, np.zeros(3)))
    np.testing.assert_allclose(metric_settings(parameters).mounting.rotation, rotation, atol=1e-6)


def test_the_defaults_look_straight_down_without_an_altitude():
    parameters = CableVehicleParameters()
    assert metric_settings(parameters).mounting.pitch == math.pi / 2
    assert parameters.fixed_altitude == 0.0


def test_a_camera_for_targets_looks_ahead_by_default():
    assert mounting_of(TargetVehicleParameters(camera_x=0.5)) == Mounting(0.5, pitch=0.0)
