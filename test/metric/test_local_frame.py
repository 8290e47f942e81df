import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import ParameterError
from cable_tracker.metric.local_frame import LocalFrame


@given(st.floats(-80.0, 80.0), st.floats(-179.0, 179.0))
def test_degrees_come_back_from_metres(latitude, longitude):
    frame = LocalFrame(latitude, longitude)
    places = np.array([[0.0, 0.0], [1000.0, -2000.0], [-3.0, 4.0]])
    degrees = frame.to_degrees(places)
    np.testing.assert_allclose(degrees[0], (latitude, longitude), atol=1e-9)
    np.testing.assert_allclose(frame.from_degrees(*degrees.T), places, atol=1e-3)


def test_a_minute_of_latitude_is_a_nautical_mile():
    frame = LocalFrame(45.0, 8.0)
    north = frame.from_degrees(np.array([45.0 + 1 / 60]), np.array([8.0]))[0, 1]
    assert north == pytest.approx(1852.0, abs=1.0)


def test_a_place_that_is_none_is_no_datum():
    with pytest.raises(ParameterError, match="no place on the earth"):
        LocalFrame(91.0, 0.0)


@pytest.mark.parametrize(("given", "longitude"), [(350.0, -10.0), (-190.0, 170.0), (7.9, 7.9)])
def test_a_longitude_is_told_between_minus_180_and_180_degrees(given, longitude):
    frame = LocalFrame(54.0, given)
    assert frame.longitude == pytest.approx(longitude)
    np.testing.assert_allclose(frame.to_degrees(np.zeros((1, 2))), [[54.0, longitude]], atol=1e-9)
