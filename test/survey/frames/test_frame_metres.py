import math
from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.metric.calibration import Calibration, CameraModel
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.survey.frames.frame_metres import write_metres, write_view

CAMERA = CameraModel(Calibration((320, 240), "plumb_bob", (300.0, 300.0), (159.5, 119.5)))


@pytest.mark.parametrize(("turn", "reach"), [(0.0, 159.5), (90.0, 119.5), (180.0, 159.5)])
def test_how_far_the_camera_sees_to_either_side_does_not_depend_on_how_it_is_turned(turn, reach):
    view = GroundView(CAMERA, Mounting(yaw=math.radians(turn)), Attitude(), 2.0, 0.02)
    row = {}
    write_view(row, view, SimpleNamespace(image_size=(320, 240)))
    assert row["half_view"] == pytest.approx(2.0 * reach / 300.0)


def test_a_camera_that_looks_ahead_sees_as_far_to_the_side_as_its_middle_row():
    view = GroundView(CAMERA, Mounting(pitch=math.radians(50.0)), Attitude(), 2.0, 0.02)
    row = {}
    write_view(row, view, SimpleNamespace(image_size=(320, 240)))
    ends = view.on_ground(np.array([[-159.5, 0.0], [159.5, 0.0]]))
    assert row["half_view"] == pytest.approx(0.5 * (ends[0, 1] - ends[1, 1]))


@pytest.mark.parametrize("look_ahead", [0.0, 1.0])
def test_the_place_looked_at_does_not_depend_on_the_look_ahead(look_ahead):
    heading, covariance = 0.3, np.diag([0.01, 0.02, 0.004, 0.001])
    ahead = 0.5 + look_ahead * math.tan(heading)
    row = {"look": 2.0}
    write_metres(row, CrossTrack(0.5, ahead, heading, 0.2, covariance, look_ahead, -3.0))
    slope = 2.0 / math.cos(heading) ** 2
    assert row["aside"] == pytest.approx(0.5 + 2.0 * math.tan(heading))
    assert row["aside_variance"] == pytest.approx(0.01 + slope**2 * 0.004)
    assert row["aside_heading"] == pytest.approx(slope * 0.004)
    assert row["heading_variance"] == pytest.approx(0.004)
