import math

import pytest

from cable_tracker.metric.altitude import Altimeter, Altitude
from cable_tracker.metric.frames import Attitude
from cable_tracker.metric.withheld import Reason, Withheld

LEVEL = Attitude()
ROLLED = Attitude(roll=0.3, pitch=-0.2)
UPRIGHT = math.cos(0.3) * math.cos(0.2)


def test_an_altimeter_below_the_vehicle_adds_its_depth():
    assert Altimeter((0.0, 0.0, -0.2), relative_sigma=0.1).read(1.0, LEVEL) == Altitude(1.2, 0.12)


def test_an_echo_sounder_measures_along_the_vehicle():
    altitude = Altimeter((0.0, 0.0, -0.2)).read(2.0, ROLLED)
    assert isinstance(altitude, Altitude)
    assert altitude.metres == pytest.approx(2.2 * UPRIGHT)


def test_an_altimeter_ahead_comes_nearer_to_the_bottom_as_the_vehicle_pitches():
    pitch, ahead = 0.2, 1.0
    measured = (2.0 - ahead * math.sin(pitch)) / math.cos(pitch)
    altitude = Altimeter((ahead, 0.0, 0.0)).read(measured, Attitude(pitch=pitch))
    assert isinstance(altitude, Altitude)
    assert altitude.metres == pytest.approx(2.0)


def test_a_vertical_altitude_is_not_turned_again():
    altitude = Altimeter(is_vertical=True).read(2.0, ROLLED)
    assert isinstance(altitude, Altitude)
    assert altitude.metres == pytest.approx(2.0)


@pytest.mark.parametrize("measured", [0.0, -1.0, math.nan, math.inf, -math.inf, 0.01, 500.0])
def test_what_is_no_altitude_is_refused(measured):
    refused = Altimeter().read(measured, LEVEL)
    assert isinstance(refused, Withheld)
    assert refused.reason is Reason.BAD_ALTITUDE


@pytest.mark.parametrize("measured", [0.4, 31.0])
def test_the_limits_of_the_altimeter_hold(measured):
    assert isinstance(Altimeter().read(measured, LEVEL, limits=(0.5, 30.0)), Withheld)


def test_a_vehicle_below_the_bottom_is_refused():
    refused = Altimeter((0.0, 0.0, 1.5)).read(1.0, LEVEL)
    assert isinstance(refused, Withheld)
    assert "altimeter_z" in refused.detail


def test_a_vehicle_upside_down_is_refused():
    refused = Altimeter().read(1.0, Attitude(roll=math.pi))
    assert isinstance(refused, Withheld)
    assert refused.reason is Reason.BAD_ATTITUDE
