from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from message_parts import FACTORY

from cable_tracker.metric.frames import roll_and_pitch
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.poses import (
    UNKNOWN_VARIANCE,
    YAW,
    Y,
    make_pose_at_origin,
    make_quaternion,
    make_stamped_pose,
    pose_covariance,
    unit_quaternion,
    yaw_of,
)

ANGLES = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3.0, 3.0))


def quaternion(x, y, z, w):
    return FACTORY.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)


@given(ANGLES)
def test_a_quaternion_holds_the_angles(angles):
    q = make_quaternion(FACTORY, *angles)
    assert yaw_of(q) == pytest.approx(angles[2], abs=1e-9)
    assert roll_and_pitch(q.x, q.y, q.z, q.w) == pytest.approx(angles[:2], abs=1e-9)


@pytest.mark.parametrize("yaw", [-3.0, -0.2, 0.0, 1.4])
def test_a_yaw_is_read_whatever_the_length_of_its_quaternion(yaw):
    assert yaw_of(
        quaternion(0.0, 0.0, 3.0 * math.sin(yaw / 2), 3.0 * math.cos(yaw / 2))
    ) == pytest.approx(yaw)


def test_a_quaternion_is_scaled_to_length_one():
    assert unit_quaternion(quaternion(0.0, 0.63, 0.0, 0.84)) == pytest.approx((0.0, 0.6, 0.0, 0.8))


@pytest.mark.parametrize(
    "spoilt", [(0.0, 0.0, 0.0, 0.0), (3.0, 0.0, 0.0, 4.0), (math.nan, 0, 0, 1)]
)
def test_a_bad_quaternion_has_no_unit_quaternion(spoilt):
    assert unit_quaternion(quaternion(*spoilt)) is None


def test_the_pose_at_the_origin_is_no_rotation():
    pose = make_pose_at_origin(FACTORY)
    assert (pose.position.x, pose.position.y, pose.position.z) == (0.0, 0.0, 0.0)
    assert unit_quaternion(pose.orientation) == (0.0, 0.0, 0.0, 1.0)


def test_unknown_components_have_a_large_variance_and_no_correlation():
    covariance = pose_covariance((Y, YAW), np.array([[0.04, 0.001], [0.003, 0.01]]))
    expected = np.diag([UNKNOWN_VARIANCE, 0.04, *[UNKNOWN_VARIANCE] * 3, 0.01])
    expected[1, 5] = expected[5, 1] = 0.002
    np.testing.assert_array_equal(covariance, expected)


def test_a_stamped_pose_is_kept_with_its_covariance(sent):
    covariance = np.arange(36.0).reshape(6, 6)
    header = make_header(FACTORY, 5, "camera")
    pose = sent(make_stamped_pose(FACTORY, header, (1.0, 2.0, 3.0), 0.4, covariance)).pose
    assert (pose.pose.position.x, pose.pose.position.y, pose.pose.position.z) == (1.0, 2.0, 3.0)
    assert yaw_of(pose.pose.orientation) == pytest.approx(0.4)
    np.testing.assert_array_equal(pose.covariance, np.arange(36.0))
