from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import RecordingError
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.recorded_instruments import (
    LOOK_AHEAD,
    LOOK_BACK,
    InstrumentFeed,
    recorded_vehicle,
)
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.sequences.bags.instruments import Instrument, InstrumentChoice
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings, write_survey_bag
from cable_tracker.tracking.status import TrackingStatus

SECOND = 1_000_000_000


class Bag:
    """Messages that were received every 100 ms for ten seconds."""

    def __init__(self):
        self.begins = []

    def messages(self, _pauses, begin):
        self.begins.append(begin)
        for received in range(0, 10 * SECOND, SECOND // 10):
            if received >= begin:
                yield SimpleNamespace(received=received)


def frame(seconds):
    received = None if seconds is None else round(seconds * SECOND)
    return SimpleNamespace(received=received)


def received(feed, seconds):
    return [each.received for each in feed.up_to(frame(seconds))]


@pytest.fixture
def small_bag():
    return Bag()


def test_each_message_is_handed_out_once_up_to_shortly_after_the_frame(small_bag):
    feed = InstrumentFeed(small_bag)
    first, second = received(feed, 1.0), received(feed, 2.0)
    assert first[0] == 0
    assert first[-1] <= SECOND + LOOK_AHEAD < second[0]
    assert second[-1] <= 2 * SECOND + LOOK_AHEAD


def test_a_frame_received_at_an_unknown_time_has_no_messages(small_bag):
    assert received(InstrumentFeed(small_bag), None) == []


def test_after_a_jump_only_what_is_shortly_before_the_frame_counts(small_bag):
    feed = InstrumentFeed(small_bag)
    received(feed, 1.0)
    feed.jump()
    assert received(feed, 6.0)[0] == 6 * SECOND - LOOK_BACK


def test_a_jump_to_the_start_hands_out_all_again(small_bag):
    feed = InstrumentFeed(small_bag)
    before = received(feed, 3.0)
    feed.jump(to_start=True)
    assert received(feed, 3.0) == before


def test_a_copy_goes_on_from_here(small_bag):
    feed = InstrumentFeed(small_bag)
    received(feed, 1.0)
    copy = feed.copy()
    expected = received(feed, 2.0)
    assert received(copy, 2.0) == expected
    assert small_bag.begins[1] == SECOND + LOOK_AHEAD + 1


def test_a_recording_without_instruments_has_no_messages():
    assert received(InstrumentFeed(None), 1.0) == []


def test_a_closed_feed_has_none(small_bag):
    feed = InstrumentFeed(small_bag)
    feed.close()
    assert received(feed, 1.0) == []


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "dive"
    write_survey_bag(path, SurveyDiveSettings(length=1.5, image_size=(64, 48), rate=5.0))
    return path


@pytest.fixture
def pictures(tmp_path):
    """A recording that is no bag."""
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 64), np.uint8))
    return tmp_path


def test_topics_of_what_is_no_bag_are_refused(pictures):
    choice = InstrumentChoice({Instrument.IMU: "none", Instrument.ALTITUDE: "/sonar"})
    with (
        open_source(pictures) as recording,
        pytest.raises(RecordingError, match=r"is no bag .* leave out --altitude-topic \("),
    ):
        recorded_vehicle(recording, choice)


def test_no_topics_may_be_wanted_of_what_is_no_bag(pictures):
    choice = InstrumentChoice(dict.fromkeys(Instrument, "none"))
    with open_source(pictures) as recording:
        assert recorded_vehicle(recording, choice).source is None


def claim(frame) -> CableEstimate:
    state = frame.truth or CableState(0.0, 0.0, 5.0, 0.0)
    return claim_at(frame.stamp, state)


def claim_at(stamp, state) -> CableEstimate:
    return CableEstimate(
        stamp, TrackingStatus.TRACKING, state, np.eye(8) * 1e-6, 100.0, 1.0, (64, 48)
    )


def measured(bag, choice=None):
    results = []
    with (
        open_source(bag) as recording,
        recorded_vehicle(recording, choice).instruments() as instruments,
    ):
        for frame in recording.frames():
            instruments.advance(frame)
            results.append(instruments.measure(claim(frame)))
    return results


def test_the_true_cable_is_found_beside_the_vehicle_in_every_frame(bag):
    results = measured(bag)
    assert len(results) > 5
    assert all(isinstance(result, CrossTrack) for result in results)
    assert all(abs(result.offset) < 0.6 and -2.5 < result.depth < -1.5 for result in results)
    diameters = [result.diameter for result in results]
    assert np.median(diameters) == pytest.approx(0.16, rel=0.2)


def test_without_an_altitude_the_reason_is_said(bag):
    choice = InstrumentChoice({Instrument.ALTITUDE: "none"})
    for result in measured(bag, choice):
        assert isinstance(result, Withheld) and result.reason is Reason.NO_ALTITUDE


def test_what_is_said_shortly_after_a_frame_is_known(bag):
    with open_source(bag) as recording, recorded_vehicle(recording).instruments() as instruments:
        frame = next(recording.frames())
        messages = instruments.advance(frame)
    latest = max(message.stamp for message in messages)
    assert frame.stamp < latest <= frame.received + 250_000_000


def test_a_recording_that_is_no_bag_has_no_instruments(tmp_path):
    (tmp_path / "0.png").write_bytes(b"")
    with open_source(tmp_path) as recording:
        assert recorded_vehicle(recording).instruments() is None


def test_a_vehicle_file_alone_lets_it_be_said_why_there_are_no_metres(tmp_path):
    (tmp_path / "0.png").write_bytes(b"")
    file = tmp_path / "vehicle.yaml"
    file.write_text("fixed_altitude: 2.0\n")
    estimate = claim_at(0, CableState(1.0, 0.1, 20.0))
    with open_source(tmp_path) as recording:
        described = recorded_vehicle(recording, vehicle_file=file)
        assert not described.has_instruments
        instruments = described.instruments()
        assert instruments.measure(estimate).reason is Reason.NO_CALIBRATION


def run(instruments, frames):
    """Measure frames with their motion; the estimate is the truth."""
    results = []
    for frame in frames:
        instruments.advance(frame)
        motion = instruments.motion(frame.stamp, decode_grey(frame.image))
        instruments.fusion.observe(claim(frame))
        known = instruments.measure(claim(frame))
        results.append(
            (
                None if motion is None else motion.mapping.tolist(),
                known.offset,
                known.covariance.tolist(),
            )
        )
    return results


@pytest.mark.parametrize("place", [0, 1, 5])
def test_a_copy_goes_on_as_the_original_does_and_as_often_as_is_wanted(bag, place):
    with open_source(bag) as recording, recorded_vehicle(recording).instruments() as instruments:
        frames = list(recording.frames())
        run(instruments, frames[:place])
        kept = instruments.copy()
        expected = run(instruments, frames[place:])
        assert any(motion is not None for motion, _, _ in expected)
        for _ in range(2):
            with kept.copy() as again:
                assert run(again, frames[place:]) == expected


def test_after_a_jump_only_the_motion_from_the_frame_before_is_unknown(bag):
    with open_source(bag) as recording, recorded_vehicle(recording).instruments() as instruments:
        frames = list(recording.frames())
        expected = run(instruments, frames)
        for place in (7, 2):
            instruments.jump()
            found = run(instruments, frames[place:])
            assert found[0][0] is None
            assert [each[1:] for each in found] == [each[1:] for each in expected[place:]]
        instruments.jump(to_start=True)
        assert run(instruments, frames) == expected


def test_a_closed_one_reads_no_more(bag):
    with open_source(bag) as recording:
        frame = next(recording.frames())
        with recorded_vehicle(recording).instruments() as instruments:
            pass
        assert instruments.advance(frame) == []
