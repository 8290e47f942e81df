import numpy as np
import pytest

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.evaluation.experiments.aided import cables_below
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation.instruments.dive_ticks import dive_ticks, vehicle_poses_at
from cable_tracker.simulation.instruments.instrument_writer import write_ticks
from cable_tracker.simulation.scenario_dive import (
    SimulationSettings,
    simulate,
    simulated_dive,
)
from cable_tracker.tracking.status import TrackingStatus

SETTINGS = SimulationSettings(frame_count=12, rate=10.0, image_size=(160, 120), clutter=0.0, seed=4)


def write_dive(path):
    dive = simulated_dive(SETTINGS)
    ticks = dive_ticks(simulate(SETTINGS), dive, SETTINGS.rate, SETTINGS.seed)
    return write_ticks(path, ticks, dive.camera, dive.tube.height)


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("plain") / "dive"
    assert write_dive(path).frames == SETTINGS.frame_count
    return path


def test_the_bag_holds_all_instruments(bag):
    with open_source(bag) as recording:
        vehicle = recorded_vehicle(recording)
    assert set(vehicle.source.found.topics) == set(Instrument)
    assert not vehicle.notes
    assert vehicle.vehicle.parameters.cable_height > 0.0


def test_odometry_speaks_some_fifty_times_a_second(bag):
    topics = open_bag(bag).topics
    assert topics["/odometry"].count == topics["/imu"].count == 5 * SETTINGS.frame_count
    assert topics["/altitude"].count == SETTINGS.frame_count


def test_the_true_cable_lies_in_metres_where_the_vehicle_has_it(bag):
    dive = simulated_dive(SETTINGS)
    times = np.arange(SETTINGS.frame_count) / SETTINGS.rate
    truths = cables_below(dive, vehicle_poses_at(dive, times))
    with open_source(bag) as recording, recorded_vehicle(recording).instruments() as instruments:
        for frame, (offset, _, heading) in zip(recording.frames(), truths, strict=True):
            instruments.advance(frame)
            estimate = CableEstimate(
                frame.stamp, TrackingStatus.TRACKING, frame.truth, np.diag([1e-2] + [1e-5] * 7),
                100.0, 3.0, SETTINGS.image_size,
            )  # fmt: skip
            known = instruments.measure(estimate)
            assert isinstance(known, CrossTrack)
            assert known.offset == pytest.approx(offset, abs=0.06)
            assert known.heading == pytest.approx(heading, abs=0.05)


def test_the_same_seed_gives_the_same_instruments(bag, tmp_path):
    again = tmp_path / "again"
    write_dive(again)
    topics = ("/odometry", "/imu", "/altitude", "/fix")
    first, second = (
        [each.data for each in open_bag(path).messages(topics)] for path in (bag, again)
    )
    assert first == second
