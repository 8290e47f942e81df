import math

import numpy as np
import pytest
from survey_dives import DISK, odometry, way

from cable_tracker.survey.frame_table import Samples
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.trajectory import joined_trajectory, poses_of_rows

SECOND = 1_000_000_000


def test_poses_are_interpolated_between_readings():
    trajectory = joined_trajectory(odometry(way()), DISK)
    middle = trajectory.at(np.array([SECOND + SECOND // 20]))[0]
    np.testing.assert_allclose(middle, way()[:2].mean(axis=0), atol=1e-9)


def test_nothing_is_known_in_a_silence_or_outside():
    stamps = [SECOND + k * SECOND // 10 + (3 * SECOND if k >= 200 else 0) for k in range(400)]
    trajectory = joined_trajectory(odometry(way(), stamps), DISK)
    asked = np.array([0, stamps[199] + SECOND, stamps[-1] + SECOND])
    assert np.isnan(trajectory.at(asked)).all()


def test_an_odometry_that_begins_anew_goes_on_where_it_was():
    places = way()
    reset = places.copy()
    turn = places[200, 2]
    cos, sin = math.cos(turn), math.sin(turn)
    reset[200:, :2] = (places[200:, :2] - places[200, :2]) @ np.array([[cos, -sin], [sin, cos]])
    reset[200:, 2] -= turn
    trajectory = joined_trajectory(odometry(reset), DISK)
    assert trajectory.jumps == (SECOND + 200 * SECOND // 10,)
    np.testing.assert_allclose(trajectory.poses, places, atol=0.03)


def test_a_clock_that_goes_back_is_a_jump_and_its_readings_do_not_count():
    stamps = [
        SECOND + k * SECOND // 10 - (15 * SECOND if 200 <= k < 210 else 0) for k in range(400)
    ]
    trajectory = joined_trajectory(odometry(way(), stamps), DISK)
    assert trajectory.jumps
    assert (np.diff(trajectory.stamps) > 0).all()
    np.testing.assert_allclose(trajectory.poses[-1], way()[-1], atol=1e-9)


@pytest.mark.parametrize("strays", [1, 5])
@pytest.mark.parametrize("seconds", [3600, -3600, -3])
@pytest.mark.parametrize("block", [7, 4096])
def test_a_few_readings_of_another_time_do_not_cost_what_follows(strays, seconds, block):
    stamps = [
        SECOND + k * SECOND // 10 + (seconds * SECOND if 200 <= k < 200 + strays else 0)
        for k in range(400)
    ]
    trajectory = joined_trajectory(odometry(way(), stamps), Disk(block=block))
    assert trajectory.strays == strays
    assert not trajectory.jumps
    assert len(trajectory.stamps) == 400 - strays
    np.testing.assert_allclose(trajectory.poses[-1], way()[-1], atol=1e-9)


def test_of_readings_that_are_ahead_by_turns_the_others_count():
    stamps = [SECOND + k * SECOND // 10 + (k % 2) * 5 * SECOND for k in range(400)]
    trajectory = joined_trajectory(odometry(way(), stamps), DISK)
    # Nothing follows the last one that would tell that it is ahead.
    assert trajectory.stamps.tolist() == [*stamps[::2], stamps[-1]]
    assert trajectory.strays == 199 and not trajectory.jumps


@pytest.mark.parametrize("block", [7, 4096])
def test_a_vehicle_goes_on_while_a_clock_that_was_set_back_catches_up(block):
    stamps = [SECOND + k * SECOND // 10 - (3 * SECOND if k >= 200 else 0) for k in range(400)]
    trajectory = joined_trajectory(odometry(way(), stamps), Disk(block=block))
    assert len(trajectory.jumps) == 1
    np.testing.assert_allclose(trajectory.poses[-1], way()[-1], atol=1e-9)


@pytest.mark.parametrize("block", [2, 4096])
def test_a_time_that_comes_again_has_the_place_of_its_first_picture_only(block):
    trajectory = joined_trajectory(odometry(way()), DISK)
    rows = np.zeros(6, [("stamp", "i8")])
    rows["stamp"] = SECOND * np.array([2, 3, 4, 3, 4, 5])
    poses = poses_of_rows(rows, trajectory, Disk(block=block))
    assert np.isfinite(poses).all(axis=1).tolist() == [True, True, True, False, True, True]


@pytest.mark.parametrize("block", [2, 4096])
def test_pictures_with_stamps_far_ahead_cost_no_place_but_their_own(block):
    trajectory = joined_trajectory(odometry(way()), DISK)
    rows = np.zeros(6, [("stamp", "i8")])
    rows["stamp"] = SECOND * np.array([2, 3, 100_000, 100_001, 4, 5])
    poses = poses_of_rows(rows, trajectory, Disk(block=block))
    assert np.isfinite(poses).all(axis=1).tolist() == [True, True, False, False, True, True]


def test_no_odometry_gives_no_poses():
    assert np.isnan(joined_trajectory(Samples(4, DISK), DISK).at(np.array([1, 2]))).all()


@pytest.mark.parametrize(("speed", "rate"), [(1.2, 2.0), (1.0, 1.25), (2.0, 3.0)])
def test_odometry_without_a_twist_is_a_way_all_the_same(speed, rate):
    readings = Samples(4, DISK)
    for k in range(100):
        readings.add(SECOND + round(k * SECOND / rate), [speed * k / rate, 0.0, 0.0, 0.0])
    trajectory = joined_trajectory(readings, DISK)
    assert not trajectory.jumps
    assert trajectory.poses[-1, 0] == pytest.approx(99 * speed / rate)


def test_it_is_known_before_which_readings_the_way_was_joined():
    places = way()
    places[200:, :2] += 30.0
    assert joined_trajectory(odometry(places), DISK).joints == (200,)
