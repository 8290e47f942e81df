import numpy as np
import pytest
from survey_dives import DISK, odometry, way

from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.survey.frame_table import Samples
from cable_tracker.survey.georeference import DRIFT_NOISE, RATE_NOISE, georeference
from cable_tracker.survey.trajectory import joined_trajectory

SECOND = 1_000_000_000

FRAME = LocalFrame(54.0, 7.9)


def fixes_of(places: np.ndarray, sigma: float, rng, stamps: list[int] | None = None) -> Samples:
    fixes = Samples(4, DISK)
    for k in range(0, len(places), 10):
        noisy = places[k : k + 1, :2] + sigma * rng.standard_normal((1, 2))
        latitude, longitude = FRAME.to_degrees(noisy)[0]
        stamp = SECOND + k * SECOND // 10 if stamps is None else stamps[k]
        fixes.add(stamp, [latitude, longitude, sigma**2, sigma**2])
    return fixes


def test_a_dive_is_turned_and_shifted_onto_the_earth():
    rng = np.random.default_rng(1)
    true = way(3000, turn=0.8) + np.array([100.0, 50.0, 0.0])
    trajectory = joined_trajectory(odometry(way(3000)), DISK)
    earth = georeference(trajectory, fixes_of(true, 0.5, rng), FRAME, DISK)
    found, variances = earth.apply(trajectory.poses[:, :2], trajectory.stamps)
    errors = np.hypot(*(found - true[:, :2]).T)
    assert errors.mean() < 0.3
    assert np.mean(errors**2 < 5.99 * variances) > 0.8


def test_odometry_that_drifts_is_held_by_the_fixes():
    rng = np.random.default_rng(2)
    true = way(3000)
    drifted = true.copy()
    drifted[:, 1] += 0.01 * np.arange(3000) / 10
    earth = georeference(
        joined_trajectory(odometry(drifted), DISK), fixes_of(true, 0.3, rng), FRAME, DISK
    )
    trajectory = joined_trajectory(odometry(drifted), DISK)
    found, _ = earth.apply(trajectory.poses[:, :2], trajectory.stamps)
    assert np.hypot(*(found - true[:, :2]).T).max() < 0.6


def test_fixes_far_off_do_not_count():
    true = way(2000)
    shown = true.copy()
    shown[500] = [400.0, 400.0, 0.0]
    fixes = fixes_of(shown, 0.3, np.random.default_rng(3))
    earth = georeference(joined_trajectory(odometry(true), DISK), fixes, FRAME, DISK)
    assert earth.left_out == 1


@pytest.mark.parametrize(("count", "off"), [(1, 100.0), (4, 700.0), (15, 700.0), (4, 50_000.0)])
def test_places_of_long_ago_at_the_beginning_do_not_turn_the_dive(count, off):
    true = way(4000, turn=0.8)
    shown = true.copy()
    shown[: 10 * count, :2] = [off, -off]
    fixes = fixes_of(shown, 0.5, np.random.default_rng(1))
    trajectory = joined_trajectory(odometry(way(4000)), DISK)
    earth = georeference(trajectory, fixes, FRAME, DISK)
    assert earth.left_out == count
    found, _ = earth.apply(trajectory.poses[:, :2], trajectory.stamps)
    assert np.hypot(*(found - true[:, :2]).T).max() < 0.5


def test_in_a_silence_of_the_receiver_the_doubt_grows():
    true, half = way(18000), 9000
    errors, doubts = [], []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        rates = np.cumsum(np.sqrt(RATE_NOISE / 10) * rng.standard_normal((18000, 2)), axis=0)
        steps = rates / 10 + np.sqrt(DRIFT_NOISE / 10) * rng.standard_normal((18000, 2))
        drifted = true.copy()
        drifted[:, :2] -= np.cumsum(steps, axis=0)
        trajectory = joined_trajectory(odometry(drifted), DISK)
        ends = Samples(4, DISK)
        for part in (slice(0, 600), slice(17400, 18000)):
            stamps, values = fixes_of(true[part], 0.3, rng).arrays()
            for stamp, value in zip(stamps.tolist(), values.tolist(), strict=True):
                ends.add(stamp + part.start * SECOND // 10, value)
        earth = georeference(trajectory, ends, FRAME, DISK)
        found, variances = earth.apply(
            trajectory.poses[half : half + 1, :2], trajectory.stamps[half : half + 1]
        )
        errors.append(((found - true[half, :2]) ** 2).mean())
        doubts.append(variances[0])
    assert 0.3 < np.mean(errors) / np.mean(doubts) < 3.0


@pytest.mark.parametrize("seconds", [5, 20, 60])
def test_where_odometry_begins_anew_the_fixes_tell_how_far_the_vehicle_went(seconds):
    true, first = way(4000), 2000
    again = first + 10 * seconds
    cos, sin = np.cos(true[again, 2]), np.sin(true[again, 2])
    anew = true[again:] - true[again]
    anew[:, :2] = anew[:, :2] @ np.array([[cos, -sin], [sin, cos]])
    rows = [*range(first), *range(again, 4000)]
    stamps = [SECOND + k * SECOND // 10 for k in rows]
    trajectory = joined_trajectory(odometry(np.concatenate((true[:first], anew)), stamps), DISK)
    fixes = fixes_of(true, 0.5, np.random.default_rng(3))
    found, _ = georeference(trajectory, fixes, FRAME, DISK).apply(
        trajectory.poses[:, :2], trajectory.stamps
    )
    assert np.hypot(*(found - true[rows, :2]).T).max() < 0.5


def test_fixes_of_times_that_come_again_move_nothing():
    # All clocks are set back by 60 s halfway.
    true = way(4000)
    stamps = [SECOND + (k if k < 2000 else k - 600) * SECOND // 10 for k in range(4000)]
    fixes = fixes_of(true, 0.3, np.random.default_rng(5), stamps)
    earth = georeference(joined_trajectory(odometry(true, stamps), DISK), fixes, FRAME, DISK)
    found, _ = earth.apply(true[:2000, :2], np.array(stamps[:2000]))
    assert np.hypot(*(found - true[:2000, :2]).T).max() < 0.3


def test_too_few_fixes_lay_nothing_on_the_earth():
    true = way(15)
    fixes = fixes_of(true, 0.3, np.random.default_rng(4))
    assert georeference(joined_trajectory(odometry(true), DISK), fixes, FRAME, DISK) is None


def test_beyond_the_fixes_the_doubt_about_the_turn_grows_with_the_way():
    true = way(3000)
    errors, doubts = [], []
    for seed in range(12):
        fixes = fixes_of(true[:100], 2.0, np.random.default_rng(seed))
        trajectory = joined_trajectory(odometry(true), DISK)
        earth = georeference(trajectory, fixes, FRAME, DISK)
        found, variances = earth.apply(trajectory.poses[-1:, :2], trajectory.stamps[-1:])
        # The error lies across the way to the fixes.
        errors.append(((found - true[-1:, :2]) ** 2).sum())
        doubts.append(variances[0])
    assert 0.2 < np.mean(errors) / np.mean(doubts) < 1.5
