from __future__ import annotations

import math

import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.altitude import Altitude
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.frames import Attitude
from cable_tracker.metric.instruments import Instruments
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import CableVehicleParameters

SECOND = 1_000_000_000
LIMITS = (0.1, 50.0)


@pytest.fixture
def estimate(make_estimate):
    return make_estimate(CableState(-50.0, 0.0, 40.0), (1.0, 0.01, 1.0, 0.01), stamp=10 * SECOND)


@pytest.fixture
def instruments(calibrations):
    instruments = Instruments(CableVehicleParameters())
    instruments.take_calibration(calibrations["pinhole"])
    return instruments


def test_with_calibration_and_altitude_there_are_metres(instruments, estimate):
    instruments.take_altitude(10 * SECOND, 1.4, LIMITS)
    result = instruments.cross_track(estimate)
    assert isinstance(result, CrossTrack)
    # The principal point of the camera is 3.5 px to the right of the image centre.
    assert result.offset == pytest.approx((50.0 + 3.5) * 1.4 / 280.0, rel=0.01)


def test_without_calibration_the_words_say_so(estimate):
    instruments = Instruments(CableVehicleParameters())
    instruments.take_altitude(10 * SECOND, 1.4, LIMITS)
    assert instruments.cross_track(estimate).reason is Reason.NO_CALIBRATION


def test_without_altitude_the_words_say_so(instruments, estimate):
    assert instruments.cross_track(estimate).reason is Reason.NO_ALTITUDE


def test_a_fixed_altitude_stands_in(instruments, estimate):
    instruments.configure(CableVehicleParameters(fixed_altitude=2.0))
    assert instruments.altitude_at(0, Attitude()) == Altitude(2.0, 0.02)
    instruments.take_altitude(10 * SECOND, 1.4, LIMITS)
    measured = instruments.altitude_at(10 * SECOND, Attitude())
    assert isinstance(measured, Altitude)
    assert measured.metres == pytest.approx(1.4)


def test_a_fixed_altitude_stands_in_for_an_altimeter_that_fell_silent(instruments):
    instruments.take_altitude(SECOND, 1.4, LIMITS)
    instruments.configure(CableVehicleParameters(fixed_altitude=2.0))
    assert instruments.altitude_at(3 * SECOND, Attitude()) == Altitude(2.0, 0.02)
    assert "altitude is more than 1 s older" in instruments.stand_in_at(3 * SECOND)
    instruments.take_altitude(3 * SECOND, 1.5, LIMITS)
    assert instruments.altitude_at(3 * SECOND, Attitude()).metres == pytest.approx(1.5)
    assert instruments.stand_in_at(3 * SECOND) == ""


def test_a_fixed_altitude_stands_in_until_the_altimeter_begins(instruments):
    # A recording knows what came a little after a picture, too.
    instruments.configure(CableVehicleParameters(fixed_altitude=2.0))
    instruments.take_altitude(int(2.2 * SECOND), 1.4, LIMITS)
    assert instruments.altitude_at(2 * SECOND, Attitude()) == Altitude(2.0, 0.02)
    # It has not fallen silent, of which there would be a warning.
    assert instruments.stand_in_at(2 * SECOND) == ""


@pytest.mark.parametrize(
    ("metres", "second", "expected"),
    [(1.4, 3.5, Reason.STALE_ALTITUDE), (60.0, 2.0, Reason.BAD_ALTITUDE)],
    ids=["of later stamps", "that cannot be"],
)
def test_a_fixed_altitude_does_not_stand_in_for_an_altimeter_that_speaks(
    instruments, metres, second, expected
):
    instruments.configure(CableVehicleParameters(fixed_altitude=2.0))
    instruments.take_altitude(int(second * SECOND), metres, LIMITS)
    told = instruments.altitude_at(2 * SECOND, Attitude())
    assert told.reason is expected
    assert instruments.stand_in_at(2 * SECOND) == ""


@pytest.mark.parametrize("metres", [0.0, math.nan, math.inf, -math.inf, 60.0])
def test_an_impossible_altitude_is_told(instruments, estimate, metres):
    instruments.take_altitude(9 * SECOND, 1.4, LIMITS)
    instruments.take_altitude(10 * SECOND, metres, LIMITS)
    assert instruments.cross_track(estimate).reason is Reason.BAD_ALTITUDE


@pytest.mark.parametrize("metres", [0.0, math.inf, 60.0])
@pytest.mark.parametrize("second", [9.5, 10.5])
def test_an_impossible_altitude_is_not_bridged_by_its_neighbours(instruments, second, metres):
    for stamp, each in ((9, 2.0), (10, metres), (11, 2.0)):
        instruments.take_altitude(stamp * SECOND, each, LIMITS)
    told = instruments.altitude_at(int(second * SECOND), Attitude())
    assert told.reason is Reason.BAD_ALTITUDE


def test_an_altitude_of_the_frames_own_time_counts_whatever_comes_next(instruments):
    for stamp, each in ((10, 2.0), (11, math.inf)):
        instruments.take_altitude(stamp * SECOND, each, LIMITS)
    assert instruments.altitude_at(10 * SECOND, Attitude()).metres == 2.0


@pytest.mark.parametrize("second", [8, 12])
def test_an_altitude_of_another_time_is_stale(instruments, estimate, second):
    instruments.take_altitude(second * SECOND, 1.4, LIMITS)
    assert instruments.cross_track(estimate).reason is Reason.STALE_ALTITUDE


def test_altitudes_long_before_and_after_are_not_interpolated(instruments, estimate):
    instruments.take_altitude(5 * SECOND, 1.4, LIMITS)
    instruments.take_altitude(15 * SECOND, 1.5, LIMITS)
    assert instruments.cross_track(estimate).reason is Reason.STALE_ALTITUDE


def test_an_imu_that_fell_silent_is_told(instruments, estimate):
    instruments.take_altitude(10 * SECOND, 1.4, LIMITS)
    instruments.take_attitude(8 * SECOND, Attitude(0.1, 0.0, 0.01))
    assert instruments.cross_track(estimate).reason is Reason.STALE_ATTITUDE


def test_an_imu_that_knows_nothing_is_told(instruments, estimate):
    instruments.take_altitude(10 * SECOND, 1.4, LIMITS)
    instruments.take_attitude(10 * SECOND, Attitude(math.nan, 0.0, 0.01))
    assert instruments.cross_track(estimate).reason is Reason.BAD_ATTITUDE


def test_the_attitude_of_the_frames_time_counts(instruments, estimate):
    instruments.take_altitude(10 * SECOND, 1.4, LIMITS)
    before = instruments.cross_track(estimate)
    instruments.take_attitude(9 * SECOND, Attitude(0.0, 0.0, 0.01))
    instruments.take_attitude(11 * SECOND, Attitude(0.2, 0.0, 0.01))
    after = instruments.cross_track(estimate)
    assert isinstance(before, CrossTrack) and isinstance(after, CrossTrack)
    # Half of the roll is there at the time of the frame.
    assert after.offset - before.offset > 0.9 * 1.4 * math.tan(0.1)
    assert instruments.attitude_at(10 * SECOND) == Attitude(0.1, 0.0, 0.01)


def test_a_vehicle_on_its_back_does_not_count_as_upright(instruments, estimate):
    instruments.take_altitude(10 * SECOND, 1.4, LIMITS)
    for tenths, degrees in ((98, 179.0), (101, -179.5), (104, 179.0)):
        attitude = Attitude(math.radians(degrees), 0.0, 0.01)
        instruments.take_attitude(tenths * SECOND // 10, attitude)
    for tenths in (99, 100, 102, 103):
        roll = instruments.attitude_at(tenths * SECOND // 10).roll
        assert math.radians(178.9) <= abs(roll) <= math.pi
    assert isinstance(instruments.cross_track(estimate), Withheld)


def test_doubt_about_the_level_makes_the_offset_less_sure(calibrations, estimate):
    sigmas = []
    for doubt in (0.0, math.degrees(0.05)):
        instruments = Instruments(CableVehicleParameters(level_sigma=doubt, fixed_altitude=1.4))
        instruments.take_calibration(calibrations["pinhole"])
        result = instruments.cross_track(estimate)
        assert isinstance(result, CrossTrack)
        sigmas.append(result.standard_deviations()[0])
    assert sigmas[1] == pytest.approx(math.hypot(sigmas[0], 1.4 * 0.05), rel=0.1)


def test_settings_change_at_once(instruments, estimate):
    instruments.take_altitude(10 * SECOND, 1.4, LIMITS)
    instruments.configure(
        CableVehicleParameters(look_ahead=3.0, altimeter_z=-0.6, instrument_timeout=0.5)
    )
    result = instruments.cross_track(estimate)
    assert isinstance(result, CrossTrack)
    assert result.look_ahead == 3.0
    assert result.depth == pytest.approx(-2.0)
