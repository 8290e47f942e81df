import math

import numpy as np
import pytest

from cable_tracker.metric.calibration import Calibration, CameraModel
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.ground_view import GroundView

CAMERA = CameraModel(Calibration((320, 240), "plumb_bob", (300.0, 300.0), (159.5, 119.5)))


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
