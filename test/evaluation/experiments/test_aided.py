from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.evaluation.evaluation_sequences import ScenarioSequence
from cable_tracker.evaluation.experiments.aided import AidedFilter, OdometryFault, faulty
from cable_tracker.metric.odometry.aiding import MotionAiding

pytestmark = pytest.mark.slow

STAMPS = [1_000_000_000 + k * 20_000_000 for k in range(100)]
TWISTS = np.random.default_rng(2).standard_normal((100, 6))


def faulty_odometry(fault):
    return faulty(STAMPS, TWISTS, fault, np.random.default_rng(0))


def test_sound_odometry_says_what_it_measures():
    arrivals, stamps, twists = faulty_odometry(OdometryFault.NONE)
    assert arrivals == stamps == STAMPS
    np.testing.assert_array_equal(twists, TWISTS)


def test_a_frozen_one_repeats_itself():
    twists = faulty_odometry(OdometryFault.FROZEN)[2]
    np.testing.assert_array_equal(twists[:50], TWISTS[:50])
    assert (twists[50:] == TWISTS[50]).all()


def test_a_hanging_one_repeats_itself_with_noise():
    twists = faulty_odometry(OdometryFault.HANGING)[2]
    assert np.abs(twists[50:] - TWISTS[50]).max() < 0.01
    assert np.unique(twists[50:, 0]).size == 50


def test_a_silent_one_stops():
    assert [len(part) for part in faulty_odometry(OdometryFault.SILENT)] == [50, 50, 50]


def test_lateness_and_wrong_stamps_are_two_things():
    arrivals, stamps, _ = faulty_odometry(OdometryFault.LATE)
    assert stamps == STAMPS and arrivals[0] == STAMPS[0] + 500_000_000
    arrivals, stamps, _ = faulty_odometry(OdometryFault.WRONG_STAMPS)
    assert arrivals == STAMPS and stamps[0] == STAMPS[0] + 500_000_000


def test_one_that_is_mounted_the_wrong_way_round():
    twists = faulty_odometry(OdometryFault.TURNED)[2]
    np.testing.assert_array_equal(twists * [-1, -1, 1, -1, -1, 1], TWISTS)


def test_one_whose_scale_is_wrong():
    np.testing.assert_allclose(faulty_odometry(OdometryFault.SCALED)[2], 1.3 * TWISTS)


@pytest.mark.parametrize(
    ("fault", "least", "most"),
    [
        (OdometryFault.NONE, 0.8, 1.0),
        (OdometryFault.LATE, 0.0, 0.0),
        (OdometryFault.TURNED, 0.0, 0.2),
    ],
)
def test_the_filter_is_told_sound_odometry_and_no_late_one(fault, least, most, monkeypatch):
    told = []
    motion = MotionAiding.motion
    monkeypatch.setattr(
        MotionAiding, "motion", lambda *known: told.append(motion(*known)) or told[-1]
    )
    method = AidedFilter("aided", preset("default"), "S3", fault).make(3)
    for frame in ScenarioSequence("S3", 36).frames(3):
        if frame.index == 0:
            method.initialise(GivenState.around(frame.truth))
        estimate = method.process(frame.image, frame.stamp)
    assert abs(estimate.state.distance - frame.truth.distance) < 10.0
    assert least <= np.mean([each is not None for each in told]) <= most
