from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scenario_states import scenario_states

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.evaluation.evaluation_sequences import ScenarioSequence
from cable_tracker.evaluation.experiments.aided import (
    EXPERIMENT_ERRORS,
    LOOK_AHEAD,
    AidedFilter,
    OdometryFault,
    faulty,
    simulated_vehicle,
)
from cable_tracker.metric.cable_instrument_fusion import CableInstrumentFusion
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.ground_view import homography, move_states
from cable_tracker.metric.odometry.aiding import MotionAiding
from cable_tracker.metric.odometry.motion import Odometry, PoseChange
from cable_tracker.simulation.instruments.dive_ticks import twists_at, vehicle_poses_at
from cable_tracker.simulation.instruments.instruments import InstrumentErrors
from cable_tracker.simulation.scenario_dive import scenario_dive
from cable_tracker.stamps import FIRST_STAMP
from cable_tracker.tracking.status import TrackingStatus

pytestmark = pytest.mark.slow

EXACT = InstrumentErrors(*[0.0] * 8)
FRAME = 40_000_000
SCENARIOS = ("S1", "S3", "S6")


STAMPS = [1_000_000_000 + k * 20_000_000 for k in range(100)]
TWISTS = np.random.default_rng(2).standard_normal((100, 6))


def estimate_of(states, index) -> CableEstimate:
    state = CableState.from_array(states[index])
    stamp = FIRST_STAMP + index * FRAME
    return CableEstimate(
        stamp, TrackingStatus.TRACKING, state, np.zeros((8, 8)), 1.0, 1.0, (320, 240)
    )


def fusion_of(vehicle) -> CableInstrumentFusion:
    fusion = CableInstrumentFusion(vehicle.parameters)
    for stamp, instrument, message in vehicle.messages:
        fusion.take_message(instrument, stamp, message)
    return fusion


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_exact_cable_in_the_image_is_the_exact_cable_on_the_bottom(scenario):
    vehicle = simulated_vehicle(scenario, 0, EXACT)
    fusion = fusion_of(vehicle)
    states = scenario_states(scenario, 0)
    errors = []
    for index in range(0, 100, 5):
        result = fusion.measure(estimate_of(states, index))
        assert isinstance(result, CrossTrack)
        found = np.array([result.offset, result.offset_ahead, result.heading])
        errors.append((found - vehicle.truths[index]) / [*[vehicle.altitudes[index]] * 2, 1.0])
        assert result.diameter == pytest.approx(0.16, rel=0.05)
        assert result.look_ahead == LOOK_AHEAD
    offset, ahead, heading = np.sqrt(np.mean(np.square(errors), axis=0))
    assert offset < 0.01 and ahead < 0.005 and math.degrees(heading) < 0.5


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_exact_odometry_predicts_how_the_cable_moves_in_the_image(scenario):
    vehicle = simulated_vehicle(scenario, 0, EXACT)
    fusion = fusion_of(vehicle)
    states = scenario_states(scenario, 0)
    odometry = Odometry()
    residuals, steps = [], []
    for stamp, said in list(zip(vehicle.odometry_stamps, vehicle.odometry, strict=True))[:150]:
        odometry.add(stamp, said.twist, said.twist_covariance)
    for index in range(60):
        before = estimate_of(states, index)
        change = odometry.motion(before.stamp, before.stamp + FRAME)
        assert isinstance(change, PoseChange)
        view = fusion.ground_view(before)
        moved = move_states(states[index : index + 1], homography(view, change))[0]
        residuals.append(states[index + 1, :2] - moved[:2])
        steps.append(states[index + 1, :2] - states[index, :2])
    rms, still = (np.sqrt(np.mean(np.square(each), axis=0)) for each in (residuals, steps))
    assert rms[0] < 0.2 and math.degrees(rms[1]) < 0.2
    assert (rms < 0.2 * still).all()


def test_twists_are_the_derivatives_of_poses():
    dive = scenario_dive("S6", 1)
    times = np.array([0.4, 0.44])
    poses = vehicle_poses_at(dive, times)
    middle = twists_at(dive, np.array([0.42]))[0]
    rotation = vehicle_poses_at(dive, np.array([0.42])).rotations()[0]
    velocity = rotation.T @ (poses.positions[1] - poses.positions[0]) / 0.04
    np.testing.assert_allclose(middle[:3], velocity, atol=0.02)
    assert middle[5] == pytest.approx((poses.angles[1, 2] - poses.angles[0, 2]) / 0.04, abs=0.05)


def twists_of(seed, errors=EXPERIMENT_ERRORS):
    return np.array([said.twist for said in simulated_vehicle("S6", seed, errors).odometry])


def test_the_instruments_of_a_seed_err_alike_each_time_and_otherwise_for_another():
    one = twists_of(1)
    simulated_vehicle.cache_clear()
    np.testing.assert_array_equal(one, twists_of(1))
    assert not np.array_equal(one, twists_of(2))


def test_the_stated_covariance_is_that_of_the_errors():
    unscaled = replace(EXPERIMENT_ERRORS, velocity_scale=0.0)
    errors = twists_of(3, unscaled) - twists_of(3, EXACT)
    stated = np.sqrt(np.diag(simulated_vehicle("S6", 3, unscaled).odometry[0].twist_covariance))
    spread = np.sqrt((errors**2).mean(axis=0))
    assert (spread < 2.0 * stated).all() and (spread > 0.5 * stated).all()


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
