import math
from copy import deepcopy
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from instrument_messages import camera_info, imu, odometry, range_message

from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.altitude import Altitude
from cable_tracker.metric.cable_instrument_fusion import CableInstrumentFusion
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.frames import Attitude
from cable_tracker.metric.odometry.motion import SWITCHED_OFF
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE

SECOND = 1_000_000_000
FRAME = SECOND // 25
LIMITS = (0.1, 50.0)
BARE = np.full((240, 320), 90, np.uint8)


@pytest.fixture
def estimate(make_estimate):
    return make_estimate(CableState(-50.0, 0.0, 40.0), (1.0, 0.01, 1.0, 0.01), stamp=SECOND)


def cable_fusion(**values):
    """Return a fusion that knows the calibration of the camera."""
    fusion = CableInstrumentFusion(CableVehicleParameters(**values))
    fusion.take_message(Instrument.CAMERA_INFO, SECOND, camera_info())
    return fusion


def test_calibration_altitude_and_attitude_make_metres(estimate):
    fusion = CableInstrumentFusion(CableVehicleParameters())
    assert fusion.measure(estimate).reason is Reason.NO_ALTITUDE
    fusion.take_message(Instrument.ALTITUDE, SECOND, range_message(1.4))
    assert fusion.measure(estimate).reason is Reason.NO_CALIBRATION
    fusion.take_message(Instrument.CAMERA_INFO, SECOND, camera_info())
    fusion.take_message(Instrument.IMU, SECOND, imu())
    result = fusion.measure(estimate)
    assert isinstance(result, CrossTrack)
    assert result.offset == pytest.approx(50.0 * 1.4 / 280.0, rel=0.01)


@pytest.mark.parametrize("variance", [-1.0, UNKNOWN_VARIANCE])
def test_an_imu_of_rates_alone_leaves_the_vehicle_level(estimate, variance):
    fusion = cable_fusion()
    fusion.take_message(Instrument.ALTITUDE, SECOND, range_message(1.4))
    without = fusion.measure(estimate)
    rates_alone = imu()
    rates_alone.orientation_covariance[0] = variance
    fusion.take_message(Instrument.IMU, SECOND, rates_alone)
    result = fusion.measure(estimate)
    assert isinstance(result, CrossTrack) and isinstance(without, CrossTrack)
    assert result.offset == without.offset
    np.testing.assert_array_equal(result.covariance, without.covariance)


@pytest.mark.parametrize("variance", [-1.0, UNKNOWN_VARIANCE])
def test_an_imu_that_no_longer_knows_its_orientation_is_told_by_its_covariance(
    make_estimate, variance
):
    fusion = cable_fusion(fixed_altitude=1.4)
    fusion.take_message(Instrument.IMU, SECOND, imu())
    unsure = imu()
    unsure.orientation_covariance[0] = variance
    fusion.take_message(Instrument.IMU, 3 * SECOND, unsure)
    told = fusion.measure(
        make_estimate(CableState(-50.0, 0.0, 40.0), (1.0, 0.01), stamp=3 * SECOND)
    )
    assert told.reason is Reason.STALE_ATTITUDE
    assert "orientation_covariance" in told.detail


def test_motion_that_is_switched_off_and_on_is_not_compared_with_an_old_picture():
    rng = np.random.default_rng(0)
    fusion = cable_fusion(fixed_altitude=1.4)
    pictures = [cv2.blur(rng.integers(0, 255, (240, 320), np.uint8), (5, 5)) for _ in range(2)]
    fusion.motion(SECOND, pictures[0])
    fusion.configure(CableVehicleParameters(fixed_altitude=1.4, motion_aid=False))
    fusion.motion(SECOND + FRAME, pictures[1])
    assert fusion.aiding.texture_motion is None
    fusion.configure(CableVehicleParameters(fixed_altitude=1.4))
    assert fusion.aiding._texture.compare(pictures[1], np.eye(3)) is None


def test_a_calibration_that_is_given_wins_over_messages(calibrations, estimate):
    fusion = CableInstrumentFusion(
        CableVehicleParameters(fixed_altitude=1.4), calibrations["pinhole"]
    )
    expected = fusion.measure(estimate)
    fusion.take_message(Instrument.CAMERA_INFO, SECOND, camera_info())
    assert fusion.measure(estimate).offset == expected.offset


def test_an_altitude_that_is_a_plain_number_counts_as_a_range_would_hold_it():
    fusion = cable_fusion()
    fusion.take_message(Instrument.ALTITUDE, SECOND, SimpleNamespace(data=1.4))
    altitude = fusion.altitude_at(SECOND, Attitude())
    assert isinstance(altitude, Altitude)
    assert altitude.metres == float(np.float32(1.4))


def test_an_instrument_that_does_not_count_is_ignored(estimate):
    fusion = cable_fusion(fixed_altitude=1.4)
    expected = fusion.measure(estimate)
    fusion.take_message(Instrument.FIX, SECOND, object())
    assert fusion.measure(estimate).offset == expected.offset


def test_other_values_keep_the_measurements_and_read_the_calibration_anew(estimate):
    fusion = cable_fusion()
    fusion.take_message(Instrument.ALTITUDE, SECOND, range_message(1.4))
    fusion.configure(CableVehicleParameters(image_is_rectified=True, camera_y=0.5))
    assert fusion.measure(estimate).offset == pytest.approx(0.5 + 50.0 * 1.4 / 250.0, rel=0.01)


def test_only_the_calibration_outlasts_a_jump(estimate):
    fusion = cable_fusion()
    fusion.take_message(Instrument.ALTITUDE, SECOND, range_message(1.4))
    fusion.forget_all()
    assert fusion.measure(estimate).reason is Reason.NO_ALTITUDE
    fusion.take_message(Instrument.ALTITUDE, SECOND, range_message(1.4))
    assert isinstance(fusion.measure(estimate), CrossTrack)


@pytest.fixture
def late_estimate(make_estimate):
    return make_estimate(CableState(-50.0, 0.0, 40.0), (1.0, 0.01, 1.0, 0.01), stamp=10 * SECOND)


@pytest.fixture
def calibrated(calibrations):
    return CableInstrumentFusion(CableVehicleParameters(), calibrations["pinhole"])


def test_with_calibration_and_altitude_there_are_metres(calibrated, late_estimate):
    calibrated.take_altitude(10 * SECOND, 1.4, LIMITS)
    result = calibrated.measure(late_estimate)
    assert isinstance(result, CrossTrack)
    # The principal point of the camera is 3.5 px to the right of the image centre.
    assert result.offset == pytest.approx((50.0 + 3.5) * 1.4 / 280.0, rel=0.01)


def test_without_calibration_the_words_say_so(late_estimate):
    calibrated = CableInstrumentFusion(CableVehicleParameters())
    calibrated.take_altitude(10 * SECOND, 1.4, LIMITS)
    assert calibrated.measure(late_estimate).reason is Reason.NO_CALIBRATION


def test_without_altitude_the_words_say_so(calibrated, late_estimate):
    assert calibrated.measure(late_estimate).reason is Reason.NO_ALTITUDE


def test_a_fixed_altitude_stands_in(calibrated, late_estimate):
    calibrated.configure(CableVehicleParameters(fixed_altitude=2.0))
    assert calibrated.altitude_at(0, Attitude()) == Altitude(2.0, 0.02)
    calibrated.take_altitude(10 * SECOND, 1.4, LIMITS)
    measured = calibrated.altitude_at(10 * SECOND, Attitude())
    assert isinstance(measured, Altitude)
    assert measured.metres == pytest.approx(1.4)


def test_a_fixed_altitude_stands_in_for_an_altimeter_that_fell_silent(calibrated):
    calibrated.take_altitude(SECOND, 1.4, LIMITS)
    calibrated.configure(CableVehicleParameters(fixed_altitude=2.0))
    assert calibrated.altitude_at(3 * SECOND, Attitude()) == Altitude(2.0, 0.02)
    assert "altitude is more than 1 s older" in calibrated.stand_in_at(3 * SECOND)
    calibrated.take_altitude(3 * SECOND, 1.5, LIMITS)
    assert calibrated.altitude_at(3 * SECOND, Attitude()).metres == pytest.approx(1.5)
    assert calibrated.stand_in_at(3 * SECOND) == ""


def test_a_fixed_altitude_stands_in_until_the_altimeter_begins(calibrated):
    # A recording knows what came a little after a picture, too.
    calibrated.configure(CableVehicleParameters(fixed_altitude=2.0))
    calibrated.take_altitude(int(2.2 * SECOND), 1.4, LIMITS)
    assert calibrated.altitude_at(2 * SECOND, Attitude()) == Altitude(2.0, 0.02)
    # It has not fallen silent, of which there would be a warning.
    assert calibrated.stand_in_at(2 * SECOND) == ""


@pytest.mark.parametrize(
    ("metres", "second", "expected"),
    [(1.4, 3.5, Reason.STALE_ALTITUDE), (60.0, 2.0, Reason.BAD_ALTITUDE)],
    ids=["of later stamps", "that cannot be"],
)
def test_a_fixed_altitude_does_not_stand_in_for_an_altimeter_that_speaks(
    calibrated, metres, second, expected
):
    calibrated.configure(CableVehicleParameters(fixed_altitude=2.0))
    calibrated.take_altitude(int(second * SECOND), metres, LIMITS)
    told = calibrated.altitude_at(2 * SECOND, Attitude())
    assert told.reason is expected
    assert calibrated.stand_in_at(2 * SECOND) == ""


@pytest.mark.parametrize("metres", [0.0, math.nan, math.inf, -math.inf, 60.0])
def test_an_impossible_altitude_is_told(calibrated, late_estimate, metres):
    calibrated.take_altitude(9 * SECOND, 1.4, LIMITS)
    calibrated.take_altitude(10 * SECOND, metres, LIMITS)
    assert calibrated.measure(late_estimate).reason is Reason.BAD_ALTITUDE


@pytest.mark.parametrize("metres", [0.0, math.inf, 60.0])
@pytest.mark.parametrize("second", [9.5, 10.5])
def test_an_impossible_altitude_is_not_bridged_by_its_neighbours(calibrated, second, metres):
    for stamp, each in ((9, 2.0), (10, metres), (11, 2.0)):
        calibrated.take_altitude(stamp * SECOND, each, LIMITS)
    told = calibrated.altitude_at(int(second * SECOND), Attitude())
    assert told.reason is Reason.BAD_ALTITUDE


def test_an_altitude_of_the_frames_own_time_counts_whatever_comes_next(calibrated):
    for stamp, each in ((10, 2.0), (11, math.inf)):
        calibrated.take_altitude(stamp * SECOND, each, LIMITS)
    assert calibrated.altitude_at(10 * SECOND, Attitude()).metres == 2.0


@pytest.mark.parametrize("second", [8, 12])
def test_an_altitude_of_another_time_is_stale(calibrated, late_estimate, second):
    calibrated.take_altitude(second * SECOND, 1.4, LIMITS)
    assert calibrated.measure(late_estimate).reason is Reason.STALE_ALTITUDE


def test_altitudes_long_before_and_after_are_not_interpolated(calibrated, late_estimate):
    calibrated.take_altitude(5 * SECOND, 1.4, LIMITS)
    calibrated.take_altitude(15 * SECOND, 1.5, LIMITS)
    assert calibrated.measure(late_estimate).reason is Reason.STALE_ALTITUDE


def test_an_imu_that_fell_silent_is_told(calibrated, late_estimate):
    calibrated.take_altitude(10 * SECOND, 1.4, LIMITS)
    calibrated.take_attitude(8 * SECOND, Attitude(0.1, 0.0, 0.01))
    assert calibrated.measure(late_estimate).reason is Reason.STALE_ATTITUDE


def test_an_imu_that_knows_nothing_is_told(calibrated, late_estimate):
    calibrated.take_altitude(10 * SECOND, 1.4, LIMITS)
    calibrated.take_attitude(10 * SECOND, Attitude(math.nan, 0.0, 0.01))
    assert calibrated.measure(late_estimate).reason is Reason.BAD_ATTITUDE


def test_the_attitude_of_the_frames_time_counts(calibrated, late_estimate):
    calibrated.take_altitude(10 * SECOND, 1.4, LIMITS)
    before = calibrated.measure(late_estimate)
    calibrated.take_attitude(9 * SECOND, Attitude(0.0, 0.0, 0.01))
    calibrated.take_attitude(11 * SECOND, Attitude(0.2, 0.0, 0.01))
    after = calibrated.measure(late_estimate)
    assert isinstance(before, CrossTrack) and isinstance(after, CrossTrack)
    # Half of the roll is there at the time of the frame.
    assert after.offset - before.offset > 0.9 * 1.4 * math.tan(0.1)
    assert calibrated.attitude_at(10 * SECOND) == Attitude(0.1, 0.0, 0.01)


def test_a_vehicle_on_its_back_does_not_count_as_upright(calibrated, late_estimate):
    calibrated.take_altitude(10 * SECOND, 1.4, LIMITS)
    for tenths, degrees in ((98, 179.0), (101, -179.5), (104, 179.0)):
        attitude = Attitude(math.radians(degrees), 0.0, 0.01)
        calibrated.take_attitude(tenths * SECOND // 10, attitude)
    for tenths in (99, 100, 102, 103):
        roll = calibrated.attitude_at(tenths * SECOND // 10).roll
        assert math.radians(178.9) <= abs(roll) <= math.pi
    assert isinstance(calibrated.measure(late_estimate), Withheld)


def test_doubt_about_the_level_makes_the_offset_less_sure(calibrations, late_estimate):
    sigmas = []
    for doubt in (0.0, math.degrees(0.05)):
        parameters = CableVehicleParameters(level_sigma=doubt, fixed_altitude=1.4)
        calibrated = CableInstrumentFusion(parameters, calibrations["pinhole"])
        result = calibrated.measure(late_estimate)
        assert isinstance(result, CrossTrack)
        sigmas.append(result.standard_deviations()[0])
    assert sigmas[1] == pytest.approx(math.hypot(sigmas[0], 1.4 * 0.05), rel=0.1)


def test_settings_change_at_once(calibrated, late_estimate):
    calibrated.take_altitude(10 * SECOND, 1.4, LIMITS)
    calibrated.configure(
        CableVehicleParameters(look_ahead=3.0, altimeter_z=-0.6, instrument_timeout=0.5)
    )
    result = calibrated.measure(late_estimate)
    assert isinstance(result, CrossTrack)
    assert result.look_ahead == 3.0
    assert result.depth == pytest.approx(-2.0)


class TestMotion:
    @staticmethod
    def driven(fusion, make_estimate, sway, frames):
        """Let a cable stand still in the image, whatever odometry says."""
        for index in range(frames):
            stamp = SECOND + index * FRAME
            fusion.take_message(
                Instrument.ODOMETRY, stamp, odometry(sway=sway + 1e-4 * (-1) ** index)
            )
            motion = fusion.motion(stamp, BARE)
            fusion.observe(make_estimate(CableState(0.0, 0.0, 40.0), (1.0, 0.01), stamp=stamp))
        return motion

    @pytest.fixture
    def seen(self, make_estimate):
        def make(state, sigmas, *, stamp):
            return make_estimate(state, (*sigmas, 1.0, 0.01), stamp=stamp)

        return make

    def test_odometry_that_agrees_aids(self, seen):
        fusion = cable_fusion(fixed_altitude=1.4)
        assert fusion.aiding.unaided is None
        assert self.driven(fusion, seen, 0.0, 30) is not None
        assert fusion.aiding.unaided is None

    def test_odometry_that_disagrees_does_not(self, seen):
        fusion = cable_fusion(fixed_altitude=1.4)
        assert self.driven(fusion, seen, 1.5, 30) is None
        assert fusion.aiding.unaided.disagrees

    def test_missing_odometry_is_no_disagreement(self, seen):
        fusion = cable_fusion(fixed_altitude=1.4)
        for index in range(2):
            assert fusion.motion(SECOND + index * FRAME, BARE) is None
            fusion.observe(seen(CableState(0.0, 0.0, 40.0), (1.0, 0.01), stamp=SECOND))
        assert fusion.aiding.unaided.why == "no odometry has come"
        assert not fusion.aiding.unaided.disagrees

    def test_it_can_be_switched_off(self, seen):
        fusion = cable_fusion(fixed_altitude=1.4, motion_aid=False)
        assert self.driven(fusion, seen, 0.0, 30) is None
        assert fusion.aiding.unaided == SWITCHED_OFF

    def test_a_copy_goes_on_by_itself(self, seen):
        fusion = cable_fusion(fixed_altitude=1.4)
        self.driven(fusion, seen, 0.0, 30)
        other = deepcopy(fusion)
        other.forget_all()
        stamp = SECOND + 30 * FRAME
        fusion.take_message(Instrument.ODOMETRY, stamp, odometry())
        assert other.motion(stamp, BARE) is None
        assert fusion.motion(stamp, BARE) is not None
