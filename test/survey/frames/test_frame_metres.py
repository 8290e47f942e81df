import math
from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.metric.calibration import CameraModel, DistortionModel
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.odometry.homography import Overflight
from cable_tracker.survey.frames.frame_metres import on_ground, put_metres, put_view

CAMERA = CameraModel((320, 240), DistortionModel.PLUMB_BOB, (300.0, 300.0), (159.5, 119.5))


def test_a_camera_that_looks_straight_down_sees_by_similar_triangles():
    flight = Overflight(CAMERA, Mounting(x=0.5, z=-0.25), Attitude(), 1.75, 0.02)
    ground = on_ground(flight, np.array([[0.0, 0.0], [30.0, 0.0], [0.0, 60.0]]))
    assert ground == pytest.approx(np.array([[0.5, 0.0], [0.5, -0.15], [0.8, 0.0]]))


def test_at_and_above_the_horizon_there_is_no_ground():
    flight = Overflight(CAMERA, Mounting(pitch=math.radians(10.0)), Attitude(), 2.0, 0.02)
    horizon = 300.0 * math.tan(math.radians(10.0))
    ground = on_ground(flight, np.array([[0.0, horizon - 1.0], [0.0, horizon + 1.0]]))
    assert ground[0, 0] > 100.0
    assert np.isnan(ground[1]).all()


@pytest.mark.parametrize("height", [0.0, -0.5])
def test_a_camera_that_is_no_higher_than_the_cable_sees_no_ground(height):
    flight = Overflight(CAMERA, Mounting(), Attitude(), height, 0.02)
    assert np.isnan(on_ground(flight, np.array([[0.0, 0.0], [30.0, -60.0]]))).all()


@pytest.mark.parametrize(("turn", "reach"), [(0.0, 159.5), (90.0, 119.5), (180.0, 159.5)])
def test_how_far_the_camera_sees_to_either_side_does_not_depend_on_how_it_is_turned(turn, reach):
    flight = Overflight(CAMERA, Mounting(yaw=math.radians(turn)), Attitude(), 2.0, 0.02)
    row = {}
    put_view(row, flight, SimpleNamespace(image_size=(320, 240)))
    assert row["half_view"] == pytest.approx(2.0 * reach / 300.0)


def test_a_camera_that_looks_ahead_sees_as_far_to_the_side_as_its_middle_row():
    flight = Overflight(CAMERA, Mounting(pitch=math.radians(50.0)), Attitude(), 2.0, 0.02)
    row = {}
    put_view(row, flight, SimpleNamespace(image_size=(320, 240)))
    ends = on_ground(flight, np.array([[-159.5, 0.0], [159.5, 0.0]]))
    assert row["half_view"] == pytest.approx(0.5 * (ends[0, 1] - ends[1, 1]))


@pytest.mark.parametrize("look_ahead", [0.0, 1.0])
def test_the_place_looked_at_does_not_depend_on_the_look_ahead(look_ahead):
    heading, covariance = 0.3, np.diag([0.01, 0.02, 0.004, 0.001])
    ahead = 0.5 + look_ahead * math.tan(heading)
    row = {"look": 2.0}
    put_metres(row, CrossTrack(0.5, ahead, heading, 0.2, covariance, look_ahead, -3.0))
    slope = 2.0 / math.cos(heading) ** 2
    assert row["aside"] == pytest.approx(0.5 + 2.0 * math.tan(heading))
    assert row["aside_variance"] == pytest.approx(0.01 + slope**2 * 0.004)
    assert row["aside_heading"] == pytest.approx(slope * 0.004)
    assert row["heading_variance"] == pytest.approx(0.004)
