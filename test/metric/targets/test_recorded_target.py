"""Bearing, range and turns of the camera from what a bag holds."""

import itertools
import math

import numpy as np
import pytest
from chase_bag import write_chase_bag

from cable_tracker.evaluation.targets.comparison import overlap
from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.metric.targets.recorded_target import (
    LONGEST_WAIT,
    node_values,
    recorded_target,
    target_parameters,
)
from cable_tracker.metric.targets.relative_state import RelativeState
from cable_tracker.metric.vehicle_description import VehicleDescription
from cable_tracker.metric.withheld import Withheld
from cable_tracker.node_parameter_tables import CableVehicleParameters, TargetVehicleParameters
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation.targets.chase import target_size
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.tracker import TargetTracker

FRAMES = 24


@pytest.fixture(scope="module")
def turning(tmp_path_factory):
    """Return bag and truth of a vehicle that turns, with calibration and odometry."""
    path = tmp_path_factory.mktemp("chase") / "bag"
    return path, write_chase_bag(path, FRAMES)


def followed(path, box, target_size=0.0):
    """Follow a target through a bag; return estimates, metres and why turns were not taken out."""
    tracker, told, unaided = TargetTracker(), [], []
    tracker.initialise(TargetStart.from_box(*box))
    with open_source(path) as source:
        described = recorded_vehicle(source)
        with recorded_target(described, target_size) as instruments:
            for frame in source.frames():
                instruments.advance(frame)
                image = decode_bgr(frame.image)
                motion = instruments.fusion.camera_motion(
                    frame.stamp, (image.shape[1], image.shape[0])
                )
                unaided.append(instruments.fusion.unaided)
                estimate = tracker.process(image, frame.stamp, motion)
                told.append((estimate, *instruments.fusion.take([estimate])))
    return told, unaided


def test_bearing_and_range_of_a_target_of_known_size_are_those_of_the_world(turning):
    path, truths = turning
    told, unaided = followed(path, truths[0][0], target_size())
    assert unaided[0].why == "no frame has come before"
    assert not any(unaided[1:])
    pairs = list(zip(told, truths, strict=True))
    assert all(overlap(each.box, box) > 0.5 for (each, _), (box, _) in pairs)
    off, ranges = [], []
    for (_, metres), (_, place) in pairs:
        ahead, left, up = place
        ray = np.array([-left, -up, ahead]) / np.linalg.norm(place)
        off.append(math.degrees(math.acos(min(float(metres.ray @ ray), 1.0))))
        assert isinstance(metres.relative, RelativeState)
        ranges.append(metres.relative.range / np.linalg.norm(place))
    assert np.median(off) < 1.0
    assert np.median(np.abs(np.array(ranges) - 1.0)) < 0.08


def test_the_homography_carries_the_target_along(turning):
    path, truths = turning
    with open_source(path) as source, recorded_target(recorded_vehicle(source)) as instruments:
        places = []
        for frame, (box, _) in zip(source.frames(), truths, strict=True):
            instruments.advance(frame)
            motion = instruments.fusion.camera_motion(frame.stamp, (320, 240))
            centre = np.array([(box[0] + box[2]) / 2 - 160, 120 - (box[1] + box[3]) / 2])
            places.append((motion, centre))
            # Only so does the next frame know from when to count.
            tracker = TargetTracker()
            instruments.fusion.take([tracker.process(decode_bgr(frame.image), frame.stamp)])
    still = [np.linalg.norm(now - before) for (_, before), (_, now) in itertools.pairwise(places)]
    left = []
    for (_, before), (motion, now) in itertools.pairwise(places):
        moved = motion.homography @ [*before, 1.0]
        left.append(np.linalg.norm(now - moved[:2] / moved[2]))
    assert max(still) > 3.0
    assert np.mean(left) < 0.5 * np.mean(still)


def follow_some(frames, instruments, tracker):
    """Follow frames, and return the homographies that they were followed with."""
    homographies = []
    for frame in frames:
        instruments.advance(frame)
        motion = instruments.fusion.camera_motion(frame.stamp, (320, 240))
        homographies.append(None if motion is None else motion.homography)
        instruments.fusion.take([tracker.process(decode_bgr(frame.image), frame.stamp, motion)])
    return homographies


def test_a_copy_goes_on_as_the_other_does(turning):
    with (
        open_source(turning[0]) as source,
        recorded_target(recorded_vehicle(source)) as instruments,
    ):
        frames, tracker = list(source.frames()), TargetTracker()
        follow_some(frames[:5], instruments, tracker)
        with instruments.copy() as other:
            there = follow_some(frames[5:9], other, tracker.copy())
        assert np.array_equal(follow_some(frames[5:9], instruments, tracker), there)


def test_after_a_jump_turns_are_known_from_the_second_frame_on(turning):
    with (
        open_source(turning[0]) as source,
        recorded_target(recorded_vehicle(source)) as instruments,
    ):
        frames = list(source.frames())
        there = follow_some(frames, instruments, TargetTracker())
        instruments.jump()
        first, *others = follow_some(frames[9:12], instruments, TargetTracker())
        assert first is None
        assert np.allclose(others, there[10:12])
        instruments.jump(to_start=True)
        first, *others = follow_some(frames[:3], instruments, TargetTracker())
        assert first is None
        assert np.array_equal(others, there[1:3])


def test_without_motion_it_is_said_why_nothing_is_compensated(tmp_path):
    ((box, _), *_) = write_chase_bag(tmp_path / "bag", 3, instruments=("camera_info",))
    told, unaided = followed(tmp_path / "bag", box)
    assert "no odometry" in unaided[1].why
    assert not isinstance(told[1][1].ray, Withheld)


def test_an_imu_does_for_turns(tmp_path):
    ((box, _), *_) = write_chase_bag(tmp_path / "bag", 6, instruments=("camera_info", "imu"))
    _, unaided = followed(tmp_path / "bag", box)
    assert not any(unaided[1:])


def test_without_calibration_there_is_no_bearing(tmp_path):
    ((box, _), *_) = write_chase_bag(tmp_path / "bag", 3, instruments=("odometry",))
    told, _ = followed(tmp_path / "bag", box)
    assert all(isinstance(metres.ray, Withheld) for _, metres in told)


def test_a_camera_of_which_nothing_is_said_looks_ahead():
    assert target_parameters(VehicleDescription()).camera_pitch == 0.0
    said = VehicleDescription(
        CableVehicleParameters(camera_pitch=30.0, look_ahead=2.0), said=frozenset({"camera_pitch"})
    )
    assert target_parameters(said, 0.4) == TargetVehicleParameters(
        camera_pitch=30.0, target_size=0.4
    )


def test_a_node_waits_for_what_a_replay_sends_of_the_motion(turning, tmp_path):
    write_chase_bag(tmp_path / "bag", 2, instruments=("camera_info",))
    waits = []
    for path in (turning[0], tmp_path / "bag"):
        with open_source(path) as source:
            waits.append(node_values(recorded_vehicle(source), 0.4)["instrument_wait"])
    assert waits == [LONGEST_WAIT, 0.0]
