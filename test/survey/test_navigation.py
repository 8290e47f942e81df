import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import ParameterError
from cable_tracker.survey.frame_table import Samples
from cable_tracker.survey.navigation import LocalFrame, georeference, joined_poses

SECOND = 1_000_000_000


def way(count: int = 400, turn: float = 0.0) -> np.ndarray:
    """x, y, yaw of a gentle bend, 10 times a second at 0.5 m/s."""
    yaw = turn + 0.2 * np.sin(np.arange(count) / 60.0)
    steps = 0.05 * np.column_stack((np.cos(yaw), np.sin(yaw)))
    return np.column_stack((np.cumsum(steps, axis=0), yaw))


def odometry(places: np.ndarray, stamps=None) -> Samples:
    samples = Samples(4)
    for k, (x, y, yaw) in enumerate(places):
        stamp = SECOND + k * SECOND // 10 if stamps is None else stamps[k]
        samples.add(stamp, [x, y, yaw, 0.5])
    return samples


def test_poses_are_interpolated_between_readings():
    poses = joined_poses(odometry(way()))
    middle = poses.at(np.array([SECOND + SECOND // 20]))[0]
    np.testing.assert_allclose(middle, way()[:2].mean(axis=0), atol=1e-9)


def test_nothing_is_known_in_a_silence_or_outside():
    stamps = [SECOND + k * SECOND // 10 + (3 * SECOND if k >= 200 else 0) for k in range(400)]
    poses = joined_poses(odometry(way(), stamps))
    asked = np.array([0, stamps[199] + SECOND, stamps[-1] + SECOND])
    assert np.isnan(poses.at(asked)).all()


def test_an_odometry_that_begins_anew_goes_on_where_it_was():
    places = way()
    reset = places.copy()
    turn = places[200, 2]
    cos, sin = math.cos(turn), math.sin(turn)
    reset[200:, :2] = (places[200:, :2] - places[200, :2]) @ np.array([[cos, -sin], [sin, cos]])
    reset[200:, 2] -= turn
    poses = joined_poses(odometry(reset))
    assert poses.jumps == (SECOND + 200 * SECOND // 10,)
    np.testing.assert_allclose(poses.places, places, atol=0.03)


def test_a_clock_that_goes_back_is_a_jump_and_its_readings_do_not_count():
    stamps = [
        SECOND + k * SECOND // 10 - (15 * SECOND if 200 <= k < 210 else 0) for k in range(400)
    ]
    poses = joined_poses(odometry(way(), stamps))
    assert poses.jumps
    assert (np.diff(poses.stamps) > 0).all()
    np.testing.assert_allclose(poses.places[-1], way()[-1], atol=1e-9)


def test_no_odometry_gives_no_poses():
    assert np.isnan(joined_poses(Samples(4)).at(np.array([1, 2]))).all()


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


FRAME = LocalFrame(54.0, 7.9)


def fixes_of(places: np.ndarray, sigma: float, rng) -> Samples:
    fixes = Samples(5)
    for k in range(0, len(places), 10):
        noisy = places[k : k + 1, :2] + sigma * rng.standard_normal((1, 2))
        latitude, longitude = FRAME.to_degrees(noisy)[0]
        stamp = SECOND + k * SECOND // 10
        fixes.add(stamp, [latitude, longitude, 0.0, sigma**2, sigma**2])
    return fixes


def test_a_dive_is_turned_and_shifted_onto_the_earth():
    rng = np.random.default_rng(1)
    true = way(3000, turn=0.8) + np.array([100.0, 50.0, 0.0])
    poses = joined_poses(odometry(way(3000)))
    earth = georeference(poses, fixes_of(true, 0.5, rng), FRAME)
    found, variances = earth.apply(poses.places[:, :2], poses.stamps)
    errors = np.hypot(*(found - true[:, :2]).T)
    assert errors.mean() < 0.3
    assert np.mean(errors**2 < 5.99 * variances) > 0.8


def test_odometry_that_drifts_is_held_by_the_fixes():
    rng = np.random.default_rng(2)
    true = way(3000)
    drifted = true.copy()
    drifted[:, 1] += 0.01 * np.arange(3000) / 10
    earth = georeference(joined_poses(odometry(drifted)), fixes_of(true, 0.3, rng), FRAME)
    poses = joined_poses(odometry(drifted))
    found, _ = earth.apply(poses.places[:, :2], poses.stamps)
    assert np.hypot(*(found - true[:, :2]).T).max() < 0.6


def test_fixes_far_off_do_not_count():
    true = way(2000)
    fixes = fixes_of(true, 0.3, np.random.default_rng(3))
    latitude, longitude = FRAME.to_degrees(np.array([[400.0, 400.0]]))[0]
    fixes.add(SECOND + 50 * SECOND + 5, [latitude, longitude, 0.0, 0.09, 0.09])
    earth = georeference(joined_poses(odometry(true)), fixes, FRAME)
    assert earth.left_out == 1


def test_too_few_fixes_lay_nothing_on_the_earth():
    true = way(15)
    fixes = fixes_of(true, 0.3, np.random.default_rng(4))
    assert georeference(joined_poses(odometry(true)), fixes, FRAME) is None
