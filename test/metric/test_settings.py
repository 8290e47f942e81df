import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.metric.frames import Mounting
from cable_tracker.metric.settings import (
    camera_parameters,
    metric_settings,
    mounting_of,
)
from cable_tracker.node_parameter_tables import CableVehicleParameters, TargetVehicleParameters

angles = st.floats(-math.pi, math.pi)


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
