import math
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from survey_dives import DISK

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.metric.calibration import Calibration, CameraModel
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.metric.recorded_instruments import RecordedVehicle
from cable_tracker.metric.vehicle_description import VehicleDescription
from cable_tracker.survey.forward_pass import (
    CROSSING_STRIDE,
    UNSAID_FIX_VARIANCE,
    CrossingSearch,
    ForwardDive,
    ForwardSettings,
    _ForwardTracker,
    read_fix,
    read_pose,
)
from cable_tracker.survey.frame_table import FrameTable

SECOND = 1_000_000_000

CAMERA = CameraModel(Calibration((320, 240), "plumb_bob", (300.0, 300.0), (159.5, 119.5)))
VIEW = GroundView(CAMERA, Mounting(), Attitude(), 3.0, 0.02)


@pytest.fixture
def run(monkeypatch):
    """Ask about pictures at times [s], with odometry or without."""

    def ask(times, most_rate=5.0, aided=True):
        monkeypatch.setattr(
            "cable_tracker.metric.recorded_instruments.RecordedCableInstruments.is_aided",
            property(lambda own: aided),
        )
        settings = ForwardSettings(most_rate=most_rate)
        vehicle = RecordedVehicle(VehicleDescription(), None)
        made = _ForwardTracker(ForwardDive("dive", DISK), settings, vehicle)
        wanted = [time for time in times if made.wants(round(time * SECOND))]
        assert made.passed_over == len(times) - len(wanted)
        return wanted

    return ask


def times_of(rate, seconds=4.0):
    return [number / rate for number in range(round(rate * seconds))]


@pytest.mark.parametrize(("rate", "every"), [(25, 5), (10, 2), (5, 1), (4, 1)])
def test_with_odometry_so_many_pictures_a_second_are_tracked(run, rate, every):
    assert run(times_of(rate)) == times_of(rate)[::every]


def test_where_rates_do_not_divide_their_mean_is_kept(run):
    assert len(run(times_of(12.5, 40.0))) == pytest.approx(200, abs=2)


def test_without_odometry_every_picture_is_tracked(run):
    assert run(times_of(25), aided=False) == times_of(25)


def test_none_is_passed_over_if_that_is_asked_for(run):
    assert run(times_of(25), most_rate=0.0) == times_of(25)


def test_after_a_silence_and_a_clock_that_jumps_back_the_count_begins_anew(run):
    assert run([0.0, 0.04, 9.0, 9.04, 1.0, 1.04, 1.2]) == [0.0, 9.0, 1.0, 1.2]


@pytest.mark.parametrize("rate", [-1.0, float("nan"), 1e9, 0.2, 0.5])
def test_a_rate_that_cannot_be_is_refused(rate):
    with pytest.raises(ParameterError, match="most-rate"):
        ForwardSettings(most_rate=rate)


def fix(latitude=54.0, longitude=7.0, variance=0.04, status=0, kind=2):
    return SimpleNamespace(
        status=SimpleNamespace(status=status), latitude=latitude, longitude=longitude,
        position_covariance=[variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0],
        position_covariance_type=kind,
    )  # fmt: skip


def test_a_fix_is_read_with_its_variances():
    assert read_fix(fix()) == [54.0, 7.0, 0.04, 0.04]


@pytest.mark.parametrize(
    "none", [{"status": -1}, {"latitude": math.nan}, {"latitude": 0.0, "longitude": 0.0}]
)
def test_what_is_no_fix_is_passed_over(none):
    assert read_fix(fix(**none)) is None


@pytest.mark.parametrize("unsaid", [{"kind": 0}, {"variance": 0.0}, {"variance": math.inf}])
def test_a_fix_that_does_not_say_how_sure_it_is_counts_little(unsaid):
    assert read_fix(fix(**unsaid))[2:] == [UNSAID_FIX_VARIANCE] * 2


def odometry(orientation=(0.0, 0.0, 0.6, 0.8), speed=0.5, x=1.0):
    pose = SimpleNamespace(
        position=SimpleNamespace(x=x, y=2.0, z=0.0),
        orientation=SimpleNamespace(**dict(zip("xyzw", orientation, strict=True))),
    )
    twist = SimpleNamespace(linear=SimpleNamespace(x=speed, y=0.0, z=0.0))
    return SimpleNamespace(pose=SimpleNamespace(pose=pose), twist=SimpleNamespace(twist=twist))


def test_odometry_is_read_with_its_yaw_and_speed():
    assert read_pose(odometry()) == pytest.approx([1.0, 2.0, 2.0 * math.asin(0.6), 0.5])


@pytest.mark.parametrize("unfilled", [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, math.nan, 1.0)])
def test_odometry_without_an_orientation_has_no_yaw_of_0(unfilled):
    assert read_pose(odometry(unfilled)) is None


def test_odometry_without_a_place_is_none():
    assert read_pose(odometry(x=math.nan)) is None


@pytest.mark.parametrize("speed", [math.nan, math.inf])
def test_odometry_whose_twist_is_not_finite_counts_as_that_without_one(speed):
    assert read_pose(odometry(speed=speed))[3] == 0.0


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
