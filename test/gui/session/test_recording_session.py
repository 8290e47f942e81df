from __future__ import annotations

import math
import os
import time
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from estimate_reader import read_estimates
from watched_session import Watched

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS
from cable_tracker.errors import FrameError, GuiError, ParameterError, RecordingError
from cable_tracker.gui.session.recording_session import RecordingRequest, RecordingSession
from cable_tracker.gui.session.tracked_recording import LONGEST_RUN
from cable_tracker.gui.tracking.commands import command_player
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.offline.cable_folder import CableFolder
from cable_tracker.offline.results import ESTIMATES, WantedResults, follow_all
from cable_tracker.offline.track_cable import (
    given_state_for,
    track_frame,
)
from cable_tracker.sequences.bags.instruments import Instrument, InstrumentChoice
from cable_tracker.sequences.pictures.shown_levels import DARK
from cable_tracker.sequences.source import open_chosen
from cable_tracker.trackers import make_tracker
from cable_tracker.tracking.status import WARMING_UP

LAST = 59
LESS_THAN_A_FRAME_A_MINUTE = 1e-5
PARAMETERS = TrackerParameters(particle_count=120, seed=4)
TABLE_ONLY = WantedResults(video=False, bag=False, pictures=False)

NAMED = InstrumentChoice({Instrument.ALTITUDE: "/dvl/altitude", Instrument.ODOMETRY: "none"})


VEHICLE = Path("vehicle.yaml")


@pytest.fixture
def watch(dive):
    opened = []

    def start(path=dive, init="truth", parameters=PARAMETERS, **options):
        request = RecordingRequest(path, init=init, **options)
        opened.append(Watched(RecordingSession(request, parameters)))
        return opened[-1]

    yield start
    for watched in opened:
        watched.session.close()


def same_belief(one, other):
    return one.row.state == other.row.state and np.array_equal(one.cloud, other.cloud)


def test_the_first_frame_is_shown_and_tracked_without_being_asked(watch):
    first = watch().at(0)
    assert first.cloud.shape == (120, 9)
    assert first.truth is not None


def test_the_last_frame_is_found_where_the_recording_does_not_count_its_frames(watch):
    watched = watch()
    watched.at(0)
    watched.session._frames.source.frame_count = None
    command_player(watched.session, "last")
    assert watched.at(LAST).frame == LAST
    assert watched.session.frame_count == LAST + 1


def start_from_truth(tracker, source):
    given = given_state_for(source, "truth", DEFAULT_LIMITS)
    assert given is not None
    tracker.initialise(given)


def test_the_result_is_that_of_the_command_track(watch, dive, tmp_path):
    with open_chosen(RecordingRequest(dive)) as source:
        tracker = make_tracker(PARAMETERS)
        start_from_truth(tracker, source)
        with CableFolder(tmp_path / "out", timing=False, wanted=TABLE_ONLY) as results:
            follow_all(source.frames(), lambda frame: track_frame(frame, tracker, results, None))
    rows = read_estimates(tmp_path / "out" / ESTIMATES)
    played = watch().play_to_the_end()
    assert [replace(played[row.frame].row, ms=None) for row in rows[1:]] == rows[1:]
    assert any(row.state is not None for row in rows)


def test_with_instruments_it_is_that_of_the_command_track_in_metres_too(
    watch, surveyed_dive, tmp_path
):
    with open_chosen(RecordingRequest(surveyed_dive)) as source:
        tracker = make_tracker(PARAMETERS)
        start_from_truth(tracker, source)
        instruments = recorded_vehicle(source).instruments()
        with CableFolder(tmp_path / "out", timing=False, wanted=TABLE_ONLY) as results:
            follow_all(
                source.frames(), lambda frame: track_frame(frame, tracker, results, instruments)
            )
    rows = read_estimates(tmp_path / "out" / ESTIMATES)
    played = watch(surveyed_dive).play_to_the_end()
    shown = [played[row.frame] for row in rows[1:]]
    assert [replace(each.row, ms=None) for each in shown] == rows[1:]
    for row, snapshot in zip(rows[1:], shown, strict=True):
        if row.metres is None:
            assert str(snapshot.metres) == row.no_metres
        else:
            assert snapshot.metres.offset == row.metres.offset
            sigma = snapshot.metres.standard_deviations()
            assert (sigma[0], sigma[2]) == (row.metres.sigma_offset, row.metres.sigma_heading)
    assert any(row.metres is not None for row in rows)


def test_instruments_change_what_the_filter_believes(watch, surveyed_dive):
    none = InstrumentChoice({Instrument.ODOMETRY: "none"})
    aided, plain = watch(surveyed_dive), watch(surveyed_dive, choice=none)
    aided, plain = aided.play_to_the_end(), plain.play_to_the_end()
    assert any(not same_belief(aided[frame], plain[frame]) for frame in plain)


def same_metres(one, other):
    """Compare what two snapshots say in metres, whatever that is."""
    if isinstance(one.metres, Withheld):
        return one.metres == other.metres
    return one.metres.offset == other.metres.offset and np.array_equal(
        one.metres.covariance, other.metres.covariance
    )


def test_going_back_gives_the_same_metres_again(watch, surveyed_dive):
    watched = watch(surveyed_dive)
    played = watched.play_to_the_end()
    for frame in (30, 24, 26, 2, max(played)):
        again = watched.go_to(frame)
        assert same_belief(again, played[frame]) and same_metres(again, played[frame])


def test_a_closed_session_reads_no_more_of_the_instruments(watch, surveyed_dive):
    watched = watch(surveyed_dive)
    watched.at(0)
    feed = watched.session._tracked.tracker._instruments._feed
    watched.session.close()
    assert feed._messages.gi_frame is None


def test_after_a_jump_and_a_reset_there_are_metres_of_the_frame_shown(watch, surveyed_dive):
    watched = watch(surveyed_dive, init="hough")
    watched.at(0)
    truth = watched.go_to(34).truth
    watched.session.initialise(GivenState.around(truth))
    known = watched.wait(lambda now: isinstance(now.metres, CrossTrack))
    assert known.frame == 34
    watched.session.initialise(GivenState.around(truth))
    again = watched.wait(lambda now: now.number > known.number)
    assert (
        abs(again.metres.offset - known.metres.offset) < 3 * known.metres.standard_deviations()[0]
    )


def test_what_is_missing_for_metres_is_said(watch, surveyed_dive):
    none = InstrumentChoice({Instrument.ALTITUDE: "none"})
    seen = watch(surveyed_dive, choice=none).at(0)
    assert seen.metres.reason is Reason.NO_ALTITUDE


def test_without_instruments_there_is_no_word_of_metres(watch):
    assert watch().at(0).metres is None


def test_going_back_gives_the_same_belief_again(watch):
    watched = watch()
    played = watched.play_to_the_end()
    for frame in (30, 26, 24, 50, LAST):
        assert same_belief(watched.go_to(frame), played[frame])


def test_stepping_back_and_on_comes_to_the_same_belief(watch):
    watched = watch()
    played = watched.play_to_the_end()
    watched.go_to(40)
    watched.session.step(-1)
    assert same_belief(watched.at(39), played[39])
    watched.session.step(3)
    assert same_belief(watched.at(42), played[42])
    assert not watched.session.is_playing


def test_at_a_frame_that_was_never_reached_the_tracker_starts_anew(watch):
    watched = watch()
    watched.at(0)
    jumped = watched.go_to(40)
    fresh = make_tracker(PARAMETERS)
    fresh.process(jumped.image, jumped.row.stamp)
    assert np.array_equal(jumped.cloud[:, :8], fresh.particles.states)


def test_on_the_way_a_little_further_on_the_frames_between_are_tracked(watch):
    through, apart = watch(), watch()
    for frame in range(1, LONGEST_RUN + 1):
        one = through.go_to(frame)
    assert same_belief(one, apart.go_to(LONGEST_RUN))


def test_at_the_first_frame_it_starts_as_it_was_told(watch):
    watched = watch()
    first = watched.at(0)
    watched.go_to(40)
    watched.session.change({"particle_count": 119})
    watched.session.change({"particle_count": 120})
    assert same_belief(watched.go_to(0), first)


@pytest.mark.parametrize("speed", [1.0, math.inf])
def test_a_faster_speed_counts_at_once_and_not_after_the_pause_of_the_slower_one(watch, speed):
    watched = watch()
    watched.at(0)
    watched.session.set_speed(LESS_THAN_A_FRAME_A_MINUTE)
    watched.session.play()
    watched.at(1)
    # Answered when the frame is done with, and the pause after it has begun.
    watched.session.change({})
    watched.session.set_speed(speed)
    watched.wait(lambda now: now.frame > 1)


def test_it_stops_at_the_end_and_plays_from_the_start_again(watch):
    watched = watch()
    watched.play_to_the_end()
    watched.session.seek(1000)
    before = watched.at(LAST)
    watched.session.play()
    watched.wait(lambda now: now.frame == LAST and now.number > before.number)
    assert [snapshot.frame for snapshot in watched.seen][-LAST - 1 :] == list(range(LAST + 1))


def test_a_parameter_counts_from_the_next_frame_on(watch):
    watched = watch()
    watched.at(0)
    watched.session.change({"particle_count": 77})
    assert watched.session.parameters()["particle_count"] == 77
    watched.session.step()
    assert len(watched.at(1).cloud) == 77


def test_a_refused_value_changes_nothing_at_all(watch):
    session = watch().session
    before = dict(session.parameters())
    with pytest.raises(ParameterError, match="outside"):
        session.change({"seed": 9, "particle_count": 0})
    with pytest.raises(ParameterError, match="must not exceed"):
        session.change({"width_minimum": 300.0})
    with pytest.raises(ParameterError, match="unknown"):
        session.change({"colour": 1})
    with pytest.raises(ParameterError):
        session.change({"response_table": "/no/such/file.json"})
    assert session.parameters() == before


def test_a_start_that_is_not_found_under_other_parameters_is_said_and_it_goes_on(watch):
    watched = watch(init="hough")
    watched.at(0)
    watched.go_to(1)
    watched.session.change({"width_maximum": 5.0, "initial_width_maximum": 5.0})
    watched.go_to(0)
    assert "hough sees no cable" in watched.session.trouble
    watched.go_to(3)
    watched.session.reset()
    assert not watched.session.trouble


def test_under_other_parameters_an_earlier_frame_is_a_jump(watch):
    watched = watch()
    played = watched.play_to_the_end()
    watched.session.change({"particle_count": 121})
    assert len(watched.go_to(30).cloud) == 121
    assert len(played[30].cloud) == 120


def test_where_it_stands_still_a_drawn_cable_is_tried_at_once(watch):
    watched = watch(init="random")
    watched.at(0)
    truth = watched.go_to(20).truth
    watched.session.initialise(GivenState.around(truth))
    now = watched.wait(lambda now: now.row.status == "TRACKING")
    assert now.frame == 20
    assert abs(now.row.state.distance - truth.distance) < 5.0


def test_what_the_user_drew_belongs_to_the_belief_that_comes_back(watch):
    watched = watch(init="random")
    watched.at(0)
    watched.session.initialise(GivenState.around(watched.go_to(20).truth))
    played = watched.play_to_the_end()
    assert same_belief(watched.go_to(22), played[22])


def test_a_state_that_is_no_number_is_refused(watch):
    watched = watch()
    before = watched.at(0)
    with pytest.raises(FrameError):
        watched.session.initialise(GivenState.around(CableState(math.nan, 0.0, 10.0)))
    assert watched.latest is before


def test_reset_forgets_the_belief_of_this_frame(watch):
    watched = watch()
    before = watched.play_to_the_end()[LAST]
    watched.session.reset()
    assert not same_belief(watched.wait(lambda now: now.number > before.number), before)


def test_switched_off_frames_pass_and_nothing_is_believed(watch):
    watched = watch()
    watched.at(0)
    watched.session.enable(False)
    watched.session.step()
    passed = watched.wait(lambda now: now.frame == 1)
    assert passed.row.status == "DISABLED"
    assert passed.cloud is None
    watched.session.enable(True)
    assert watched.wait(lambda now: now.cloud is not None).frame == 1


def test_without_listeners_it_goes_on(watch):
    watched = watch()
    # It stands still: nothing is told until it plays.
    watched.at(0)
    end = watched.session.listen(watched.seen.append)
    end()
    end()
    watched.play_to_the_end()
    numbers = [snapshot.number for snapshot in watched.seen]
    assert len(numbers) == len(set(numbers))


def test_a_damaged_recording_is_told_and_the_frames_before_stay(watch, tmp_path, dive):
    damaged = tmp_path / "damaged"
    damaged.mkdir()
    for picture in sorted(dive.parent.glob("*.png"))[:6]:
        (damaged / picture.name).write_bytes(picture.read_bytes())
    sorted(damaged.glob("*.png"))[4].write_bytes(b"no picture")
    watched = watch(damaged, init="random")
    watched.at(0)
    watched.session.play()
    watched.at(3)
    watched.session.seek(2)
    watched.at(2)
    watched.session.play()
    watched.at(3)
    watched.session.reset()
    assert "frame 4 (frame_000004.png) cannot be decoded" in watched.session.trouble
    assert not watched.session.is_playing


def test_a_frame_that_cannot_be_used_is_refused_and_the_next_is_tracked(watch, tmp_path, dive):
    folder = tmp_path / "one_bad"
    folder.mkdir()
    for picture in sorted(dive.parent.glob("*.png"))[:6]:
        (folder / picture.name).write_bytes(picture.read_bytes())
    sorted(folder.glob("*.png"))[2].write_bytes(b"no picture")
    played = watch(folder, init="random", skip_bad_frames=True).play_to_the_end()
    assert played[2].row.status == "REFUSED"
    assert played[2].row.event
    # Not the picture of the frame before.
    assert (played[2].image == DARK).all()
    assert len(played[3].cloud) == 120


def test_deep_grey_levels_are_shown_in_eight_bits(watch, tmp_path):
    folder = tmp_path / "deep"
    folder.mkdir()
    for number in range(2):
        deep = np.tile(np.linspace(100, 900, 64).astype(np.uint16), (48, 1))
        assert cv2.imwrite(str(folder / f"{number}.png"), deep)
    image = watch(folder, init="random").at(0).image
    assert image.dtype == np.uint8
    assert np.ptp(image) > 25


@pytest.mark.parametrize("name", ["missing", "empty"])
def test_what_cannot_be_opened_is_said(tmp_path, name):
    if name == "empty":
        (tmp_path / name).mkdir()
    with pytest.raises(RecordingError, match=name):
        RecordingSession(RecordingRequest(tmp_path / name), PARAMETERS)


def test_a_start_that_cannot_be_is_said(dive):
    with pytest.raises(ParameterError):
        RecordingSession(RecordingRequest(dive, init="nonsense"), PARAMETERS)


def test_a_closed_session_takes_no_commands(watch):
    watched = watch()
    watched.at(0)
    watched.session.close()
    with pytest.raises(GuiError, match="closed"):
        watched.session.reset()


def test_steps_count_from_where_they_lead_while_it_is_on_its_way(watch):
    watched = watch()
    watched.go_to(LAST)
    for _ in range(4):
        # Each step back tracks some frames anew; the next one comes in the middle of that.
        watched.session.step(-1)
        time.sleep(0.005)
    watched.at(LAST - 4)
    assert watched.latest.frame == LAST - 4


def test_the_end_of_a_damaged_recording_is_its_last_frame(watch, tmp_path):
    path = tmp_path / "cut.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25, (160, 120))
    for level in range(40):
        writer.write(np.full((120, 160, 3), 5 * level, np.uint8))
    writer.release()
    os.truncate(path, path.stat().st_size // 2)
    watched = watch(path, init="random")
    watched.at(0)
    watched.session.seek(39)
    last = watched.wait(lambda now: now.frame > 5 and now.row.status != WARMING_UP)
    assert last.frame == watched.session.frame_count - 1
    assert "damaged" in watched.session.trouble


@pytest.mark.parametrize(
    ("path", "choice", "vehicle"),
    [
        (Path(), NAMED, VEHICLE),
        (Path("dive"), NAMED, VEHICLE),
        (Path("other"), InstrumentChoice(), None),
    ],
)
def test_topics_and_vehicle_are_those_of_the_recording_named_with_them_or_of_the_first(
    path, choice, vehicle
):
    request = RecordingRequest(path, choice=NAMED, vehicle=VEHICLE, init="truth", rate=5.0)
    expected = RecordingRequest(
        Path("dive"), choice=choice, vehicle=vehicle, init="truth", rate=5.0
    )
    assert request.for_other(Path("dive")) == expected
