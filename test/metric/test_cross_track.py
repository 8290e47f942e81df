from __future__ import annotations

import dataclasses
import math

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import MetricError
from cable_tracker.metric.altitude import Altitude
from cable_tracker.metric.cross_track import CrossTrack, CrossTrackMeter, MetricSettings
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.tracking.status import TrackingStatus

DEGREE = math.pi / 180
LEVEL = Attitude()
HEIGHT = Altitude(1.4)
DOWN = Mounting()


def meter(calibration, mounting=DOWN, **changes) -> CrossTrackMeter:
    return CrossTrackMeter(MetricSettings(mounting, **changes), calibration)


def measured(meter, estimate, altitude=HEIGHT, attitude=LEVEL) -> CrossTrack:
    result = meter.measure(estimate, altitude, attitude)
    assert isinstance(result, CrossTrack), str(result)
    return result


def reason(meter, estimate, altitude=HEIGHT, attitude=LEVEL) -> Reason:
    result = meter.measure(estimate, altitude, attitude)
    assert isinstance(result, Withheld)
    assert result.detail
    return result.reason


class TestSigns:
    """The camera looks straight down, the top of the image is the front."""

    @pytest.fixture
    def meter(self, calibrations):
        centred = dataclasses.replace(
            calibrations["pinhole"], centre=(159.5, 119.5), focal=(280.0, 280.0)
        )
        return meter(centred)

    def test_a_cable_left_in_the_image_is_left_of_the_vehicle(self, meter, make_estimate):
        result = measured(meter, make_estimate(CableState(-50.0, 0.0, 40.0)))
        assert result.offset == pytest.approx(50.0 * 1.4 / 280.0)
        assert result.offset_ahead == pytest.approx(result.offset)
        assert result.heading == pytest.approx(0.0)

    def test_a_cable_whose_top_leans_left_leads_to_the_left(self, meter, make_estimate):
        result = measured(meter, make_estimate(CableState(0.0, 0.2, 40.0)))
        assert result.heading == pytest.approx(0.2)
        assert result.offset == pytest.approx(0.0)
        assert result.offset_ahead == pytest.approx(math.tan(0.2))

    def test_the_diameter_is_that_of_the_strip(self, meter, make_estimate):
        result = measured(meter, make_estimate(CableState(0.0, 0.0, 40.0)))
        assert result.diameter == pytest.approx(40.0 * 1.4 / 280.0, rel=0.01)

    def test_neither_an_error_of_the_skew_nor_a_large_sigma_makes_a_thin_cable_thicker(
        self, meter, make_estimate
    ):
        estimate = make_estimate(CableState(20.0, 0.3, 6.0))
        exact = measured(meter, estimate).diameter
        assert exact == pytest.approx(6.0 * 1.4 / 280.0, rel=0.02)
        for skew in (-2.0, 2.0):
            turned = make_estimate(CableState(20.0, 0.3, 6.0, skew * DEGREE))
            assert measured(meter, turned).diameter == pytest.approx(exact, rel=0.05)
        wide = np.diag([9.0, 1e-3, 25.0, 1e-3, *[1e-6] * 4])
        unsure = measured(meter, dataclasses.replace(estimate, covariance=wide))
        assert unsure.diameter == pytest.approx(exact, rel=0.02)
        assert unsure.standard_deviations()[3] > 0.3 * exact

    def test_a_cable_above_the_bottom_is_nearer(self, calibrations, make_estimate):
        estimate = make_estimate(CableState(-50.0, 0.0, 40.0))
        on, above = (
            measured(meter(calibrations["pinhole"], cable_height=height), estimate)
            for height in (0.0, 0.7)
        )
        assert above.offset == pytest.approx(on.offset / 2)
        assert above.depth == pytest.approx(-0.7)

    def test_the_camera_on_the_left_side_sees_the_same_cable_farther_right(
        self, calibrations, make_estimate
    ):
        estimate = make_estimate(CableState(10.0, 0.0, 40.0))
        centre = measured(meter(calibrations["pinhole"]), estimate)
        left = measured(meter(calibrations["pinhole"], Mounting(y=0.4)), estimate)
        assert left.offset - centre.offset == pytest.approx(0.4)

    def test_rolling_right_side_down_moves_the_view_to_the_left(self, meter, make_estimate):
        estimate = make_estimate(CableState(0.0, 0.0, 40.0))
        rolled = measured(meter, estimate, attitude=Attitude(roll=0.1))
        # What is in the middle of the image lies where the line of sight meets the bottom.
        assert rolled.offset == pytest.approx(1.4 * math.tan(0.1))


@settings(
    max_examples=15,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    offset=st.floats(-0.3, 0.3),
    heading=st.floats(-25 * DEGREE, 25 * DEGREE),
    altitude=st.floats(0.9, 2.5),
    tilt=st.floats(45 * DEGREE, 90 * DEGREE),
    roll=st.floats(-6 * DEGREE, 6 * DEGREE),
    pitch=st.floats(-6 * DEGREE, 6 * DEGREE),
    yaw=st.floats(-10 * DEGREE, 10 * DEGREE),
)
def test_a_cable_on_the_bottom_is_found_again(
    make_flight, make_estimate, camera_of, calibrations,
    offset, heading, altitude, tilt, roll, pitch, yaw,
):  # fmt: skip
    flight = make_flight(
        offset,
        heading,
        altitude=Altitude(altitude),
        attitude=Attitude(roll, pitch),
        mounting=Mounting(0.2, -0.05, -0.1, 0.02, tilt, yaw),
    )
    calibration = calibrations["pinhole"]
    camera = camera_of(calibration)
    assume(flight.is_in_view(camera))
    estimate = make_estimate(flight.seen_by(camera))
    result = measured(
        meter(calibration, flight.mounting, look_ahead=0.7),
        estimate,
        flight.altitude,
        flight.attitude,
    )
    # The middle of the image's two borders is the middle of the strip but for perspective.
    near = 0.02 * altitude
    assert result.offset == pytest.approx(offset, abs=near)
    assert result.offset_ahead == pytest.approx(offset + 0.7 * math.tan(heading), abs=near)
    assert result.heading == pytest.approx(heading, abs=0.6 * DEGREE)
    # So is its width: near the edge of the picture, low above the bottom, by a tenth.
    assert result.diameter == pytest.approx(flight.diameter, rel=0.12)


@pytest.mark.parametrize("offset", [-0.35, 0.0, 0.3])
@pytest.mark.parametrize("heading", [-0.35, 0.0, 0.3])
def test_the_distortion_of_the_lens_is_corrected(
    calibration, make_flight, make_estimate, camera_of, offset, heading
):
    flight = make_flight(offset, heading)
    estimate = make_estimate(flight.seen_by(camera_of(calibration)))
    result = measured(meter(calibration, flight.mounting), estimate, flight.altitude)
    assert result.offset == pytest.approx(offset, abs=0.03 * flight.altitude.metres)
    assert result.heading == pytest.approx(heading, abs=1.5 * DEGREE)
    assert result.diameter == pytest.approx(flight.diameter, rel=0.15)


def test_without_attitude_a_rolled_vehicle_errs_by_as_much_as_it_rolls(
    make_flight, make_estimate, camera_of, calibrations
):
    flight = make_flight(0.0, 0.0, attitude=Attitude(roll=5 * DEGREE), mounting=DOWN)
    calibration = calibrations["pinhole"]
    estimate = make_estimate(flight.seen_by(camera_of(calibration)))
    blind = measured(meter(calibration), estimate, flight.altitude)
    told = measured(meter(calibration), estimate, flight.altitude, flight.attitude)
    assert abs(blind.offset) == pytest.approx(1.4 * math.tan(5 * DEGREE), rel=0.02)
    assert told.offset == pytest.approx(0.0, abs=2e-3)


class TestCovariance:
    @pytest.mark.parametrize(
        "sigmas",
        [
            pytest.param((2.0, 0.5 * DEGREE, 2.0, 0.5 * DEGREE), marks=pytest.mark.slow),
            (12.0, 6 * DEGREE, 8.0, DEGREE),
        ],
    )
    def test_it_agrees_with_monte_carlo(
        self, calibration, make_flight, make_estimate, camera_of, sigmas
    ):
        altitude, attitude = Altitude(1.4, 0.05), Attitude(0.02, -0.03, 1.5 * DEGREE)
        flight = make_flight(0.15, 0.2, altitude=altitude, attitude=attitude)
        state = flight.seen_by(camera_of(calibration))
        instrument = meter(calibration, flight.mounting)
        result = measured(instrument, make_estimate(state, sigmas), altitude, attitude)

        rng = np.random.default_rng(7)
        drawn = []
        for noise in rng.standard_normal((250, 7)):
            shifted = CableState(*(state.to_array()[:4] + noise[:4] * sigmas))
            one = measured(
                instrument,
                make_estimate(shifted),
                Altitude(1.4 + 0.05 * noise[4]),
                Attitude(0.02 + 1.5 * DEGREE * noise[5], -0.03 + 1.5 * DEGREE * noise[6]),
            )
            drawn.append((one.offset, one.offset_ahead, one.heading, one.diameter))
        values = np.array(drawn)
        spread = np.cov(values.T)
        own = np.sqrt(np.diag(spread))
        np.testing.assert_allclose(result.standard_deviations(), own, rtol=0.15)
        found = (result.offset, result.offset_ahead, result.heading, result.diameter)
        assert (np.abs(np.array(found) - values.mean(axis=0)) < 0.15 * own).all()
        correlations = result.covariance / np.outer(own, own) - spread / np.outer(own, own)
        assert np.abs(correlations).max() < 0.25

    def test_a_surer_altitude_makes_a_surer_offset(self, calibrations, make_estimate):
        estimate = make_estimate(CableState(60.0, 0.0, 40.0), (1.0, 0.01, 1.0, 0.01))
        instrument = meter(calibrations["pinhole"])
        sure, unsure = (measured(instrument, estimate, Altitude(1.4, s)) for s in (0.0, 0.1))
        assert unsure.standard_deviations()[0] > 1.5 * sure.standard_deviations()[0]

    def test_the_offset_is_less_sure_far_ahead(self, calibrations, make_estimate):
        estimate = make_estimate(CableState(0.0, 0.0, 40.0), (1.0, 0.02, 1.0, 0.01))
        result = measured(meter(calibrations["pinhole"], look_ahead=5.0), estimate)
        sigmas = result.standard_deviations()
        assert sigmas[1] > 5 * sigmas[0]

    def test_what_is_published_is_cut_from_it(self, calibrations, make_estimate):
        estimate = make_estimate(CableState(20.0, 0.1, 40.0), (1.0, 0.02, 1.0, 0.01))
        result = measured(meter(calibrations["pinhole"]), estimate)
        for place, (offset, covariance) in enumerate((result.at_foot(), result.ahead())):
            assert offset == (result.offset, result.offset_ahead)[place]
            assert np.diag(covariance) == pytest.approx(
                [result.covariance[place, place], result.covariance[2, 2]]
            )


class TestWithheld:
    @pytest.fixture
    def estimate(self, make_estimate):
        return make_estimate(CableState(10.0, 0.1, 40.0), (1.0, 0.01, 1.0, 0.01))

    @pytest.fixture
    def meter(self, calibrations):
        return meter(calibrations["plumb_bob"])

    @pytest.mark.parametrize("status", [TrackingStatus.LOST, TrackingStatus.INITIALISING])
    def test_no_cable_is_claimed(self, meter, make_estimate, status):
        estimate = make_estimate(CableState(10.0, 0.1, 40.0), status=status)
        assert reason(meter, estimate) is Reason.NOT_TRACKING

    def test_without_a_calibration_metres_are_withheld(self, estimate):
        assert reason(CrossTrackMeter(MetricSettings()), estimate) is Reason.NO_CALIBRATION

    def test_a_calibration_of_another_aspect_withholds_metres(self, meter, make_estimate):
        other = make_estimate(CableState(10.0, 0.1, 40.0), size=(320, 200))
        assert reason(meter, other) is Reason.OTHER_IMAGE_SIZE

    def test_what_is_withheld_below_is_handed_on(self, meter, estimate):
        missing = Withheld(Reason.NO_ALTITUDE, "none has come")
        assert meter.measure(estimate, missing, LEVEL) is missing

    def test_an_attitude_that_is_no_number_withholds_metres(self, meter, estimate):
        assert reason(meter, estimate, attitude=Attitude(math.nan)) is Reason.BAD_ATTITUDE

    @pytest.mark.parametrize(
        "altitude",
        [Altitude(math.nan), Altitude(math.inf), Altitude(500.0), Altitude(-1.0)]
        + [Altitude(1.4, sigma) for sigma in (math.nan, math.inf, -1.0)],
    )
    def test_an_altitude_that_is_none_withholds_metres(self, meter, estimate, altitude):
        assert reason(meter, estimate, altitude) is Reason.BAD_ALTITUDE

    @pytest.mark.parametrize("setting", ["look_ahead", "cable_height"])
    def test_settings_that_are_no_numbers_are_refused(self, setting):
        with pytest.raises(MetricError, match=setting):
            MetricSettings(**{setting: math.nan})

    @pytest.mark.parametrize("mounting", [{"x": 1e200}, {"y": 1e200}, {"z": 1e200}])
    def test_a_position_beyond_all_numbers_withholds_metres(self, calibrations, estimate, mounting):
        far = meter(calibrations["plumb_bob"], Mounting(**mounting))
        assert reason(far, estimate) is Reason.NOT_COMPUTED

    @pytest.mark.parametrize("pitch", [-90.0, -20.0, 0.0, 2.0])
    def test_a_camera_that_looks_up_withholds_metres(self, calibrations, estimate, pitch):
        upwards = meter(calibrations["plumb_bob"], Mounting(pitch=pitch * DEGREE))
        assert reason(upwards, estimate) is Reason.CAMERA_LOOKS_UP

    def test_a_camera_in_the_ground_withholds_metres(self, calibrations, estimate):
        low = meter(calibrations["plumb_bob"], Mounting(z=-1.5))
        assert reason(low, estimate) is Reason.CAMERA_TOO_LOW

    def test_an_estimate_outside_the_image(self, meter, make_estimate):
        assert reason(meter, make_estimate(CableState(900.0, 0.0, 40.0))) is Reason.OUT_OF_VIEW

    def test_a_cable_across(self, meter, make_estimate):
        across = make_estimate(CableState(0.0, 89 * DEGREE, 40.0))
        assert reason(meter, across) is Reason.ACROSS

    def test_a_line_in_the_sky(self, calibrations, make_estimate):
        # Half the picture is above the horizon, and the line lies across that half.
        forward = meter(calibrations["pinhole"], Mounting(pitch=10 * DEGREE))
        sky = make_estimate(CableState(100.0, 89 * DEGREE, 10.0))
        assert reason(forward, sky) is Reason.HORIZON

    def test_a_reason_says_what_to_do(self, estimate):
        result = CrossTrackMeter(MetricSettings()).measure(estimate, Altitude(1.0), LEVEL)
        assert str(result) == (
            "no camera calibration: no camera_info has come; publish one beside the images"
        )


def test_points_above_the_horizon_do_not_disturb_those_below(
    calibrations, make_flight, make_estimate, camera_of
):
    # The upper third of the picture shows no bottom.
    mounting = Mounting(pitch=12 * DEGREE)
    flight = make_flight(0.1, 0.05, mounting=mounting)
    calibration = calibrations["pinhole"]
    estimate = make_estimate(flight.seen_by(camera_of(calibration)))
    result = measured(meter(calibration, mounting), estimate)
    assert result.heading == pytest.approx(0.05, abs=DEGREE)
    assert result.offset == pytest.approx(0.1, abs=0.05)


@pytest.mark.parametrize("names", [("undistortPoints", "undistortPointsIter"), ("projectPoints",)])
def test_what_opencv_refuses_withholds_the_metres_with_its_words(
    calibrations, make_estimate, monkeypatch, names
):
    def refuse(*_, **__):
        raise cv2.error("bad argument")

    for name in names:
        monkeypatch.setattr(cv2, name, refuse, raising=False)
    estimate = make_estimate(CableState(10.0, 0.1, 40.0))
    result = meter(calibrations["plumb_bob"]).measure(estimate, HEIGHT, LEVEL)
    assert isinstance(result, Withheld)
    assert result.reason is Reason.NOT_COMPUTED
    assert "bad argument" in result.detail


def test_what_numpy_refuses_withholds_the_metres(calibrations, make_estimate, monkeypatch):
    def refuse(*_, **__):
        raise np.linalg.LinAlgError("Eigenvalues did not converge")

    monkeypatch.setattr(np.linalg, "eigh", refuse)
    estimate = make_estimate(CableState(10.0, 0.1, 40.0))
    assert reason(meter(calibrations["pinhole"]), estimate) is Reason.NOT_COMPUTED


@pytest.mark.parametrize("instruments", [(1.4, Attitude()), (Altitude(1.4), (0.0, 0.0))])
def test_numbers_in_place_of_instruments_are_refused_with_an_example(
    calibrations, make_estimate, instruments
):
    estimate = make_estimate(CableState(10.0, 0.1, 40.0))
    with pytest.raises(MetricError, match=r"Altitude\(2\.0, sigma=0\.02\), Attitude\(0\.0, 0\.0\)"):
        meter(calibrations["pinhole"]).measure(estimate, *instruments)
