import math
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from survey_dives import DISK

from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.calibration import Calibration, CameraModel
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.survey.frames.crossing_search import CROSSING_STRIDE, CrossingSearch
from cable_tracker.survey.frames.frame_table import FrameTable

CAMERA = CameraModel(Calibration((320, 240), "plumb_bob", (300.0, 300.0), (159.5, 119.5)))
VIEW = GroundView(CAMERA, Mounting(), Attitude(), 3.0, 0.02)
SECOND = 1_000_000_000


def picture(*lines):
    """Draw bright strips between points from the image centre, y up [px]."""
    noise = np.random.default_rng(2).normal(0.0, 3.0, (240, 320))
    drawn = np.full((240, 320), 70, np.uint8)
    for (x0, y0), (x1, y1) in lines:
        cv2.line(drawn, (160 + x0, 120 - y0), (160 + x1, 120 - y1), 170, 24, cv2.LINE_AA)
    return np.clip(drawn + noise, 0, 255).astype(np.uint8)


CABLE = (0, -150), (0, 150)
ACROSS = (-200, 40), (200, 40)
BESIDE = (60, -150), (90, 150)


@pytest.fixture
def search():
    """Search pictures that come with so many seconds between them; return what was seen."""

    def run(*pictures, pause=1.0, back=0.0, view=VIEW):
        """`back`: by how much the clock is set back after the first picture [s]."""
        table = FrameTable(DISK)
        crossings = CrossingSearch(table)
        for number, grey in enumerate(pictures):
            table.append()
            estimate = SimpleNamespace(
                stamp=round((number * pause - (back if number else 0.0)) * SECOND),
                state=CableState(0.0, 0.0, 24.0),
                image_size=grey.shape[::-1],
            )
            crossings.search(view, grey, estimate)
        return table.crossings

    return run


def test_a_line_across_is_noted_with_its_place_and_direction(search):
    (observation,) = search(picture(CABLE, ACROSS))
    assert observation.row == 0
    assert observation.ahead == pytest.approx(0.4, abs=0.05)
    assert abs(observation.angle) == pytest.approx(math.pi / 2, abs=0.05)


def test_the_cable_and_what_lies_along_it_are_not_across(search):
    assert search(picture(CABLE, BESIDE)) == []


def test_pictures_are_searched_now_and_then(search):
    pictures = [picture(CABLE, ACROSS)] * 4
    assert {observation.row for observation in search(*pictures, pause=0.5 * CROSSING_STRIDE)} == {
        0,
        2,
    }


def test_a_clock_that_is_set_back_does_not_end_the_search(search):
    pictures = [picture(CABLE, ACROSS)] * 3
    assert {observation.row for observation in search(*pictures, back=3600.0)} == {0, 1, 2}


def test_a_long_low_picture_is_searched_like_any_other(search):
    assert search(np.full((20, 640), 70, np.uint8)) == []


def test_a_line_above_the_horizon_is_none_on_the_ground(search):
    ahead = replace(VIEW, mounting=Mounting(pitch=math.radians(3.0)))
    below = (-200, -60), (200, -60)
    assert len(search(picture(CABLE, below), view=ahead)) == 1
    assert search(picture(CABLE, ACROSS), view=ahead) == []
