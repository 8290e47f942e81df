from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from estimate_reader import read_estimates
from rosbags.highlevel import AnyReader

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS
from cable_tracker.errors import ParameterError, RecordingError
from cable_tracker.offline.cable_folder import CableFolder
from cable_tracker.offline.results import BAG, ESTIMATES, WantedResults, follow_all
from cable_tracker.offline.track_cable import (
    given_state_for,
    track_frame,
)
from cable_tracker.sequences.messages.cable import read_particles, read_sigma, read_state
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.trackers import CableTracker

EVERY_TOPIC = {
    "/state",
    "/centreline",
    "/particles",
    "/markers",
    "/ground_truth",
    "/tracker/overlay/compressed",
    "/tracker/frame_report",
}


TABLE_AND_BAG = WantedResults(video=False, pictures=False)
"""Video, plots and the sheet of pictures are tested with their folder."""


@pytest.fixture
def track(tmp_path):
    """Track a recording into a folder; return the folder and the damage."""

    def run(recording, *, given=None, name="out", timing=False, count=None):
        tracker = CableTracker(TrackerParameters(particle_count=count or 200))
        if given is not None:
            tracker.initialise(given)
        with CableFolder(tmp_path / name, timing=timing, wanted=TABLE_AND_BAG) as results:
            damage = follow_all(
                recording.frames(), lambda frame: track_frame(frame, tracker, results, None)
            )
        return results.path, damage

    return run


def messages_of(folder) -> dict[str, list]:
    found: dict[str, list] = {}
    with AnyReader([folder / BAG]) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append(message)
    return found


@pytest.fixture
def rows_and_messages(track, make_recording) -> tuple[list, dict[str, list]]:
    """Table and bag of a recording of 12 frames that is tracked from its truth."""
    recording = make_recording()
    folder, damage = track(recording, given=given_state_for(recording, "truth", DEFAULT_LIMITS))
    assert damage is None
    return read_estimates(folder / ESTIMATES), messages_of(folder)


def test_every_frame_has_a_row(rows_and_messages, dive):
    rows, _ = rows_and_messages
    assert [row.frame for row in rows] == list(range(12))
    assert [row.stamp for row in rows] == [frame.stamp for frame in dive]
    assert {row.status for row in rows} == {"TRACKING"}


def test_every_frame_has_a_message_on_every_topic(rows_and_messages):
    _, messages = rows_and_messages
    counts = {topic: len(of_topic) for topic, of_topic in messages.items()}
    assert counts == dict.fromkeys(EVERY_TOPIC, 12)


def test_the_states_of_the_bag_are_those_of_the_table(rows_and_messages):
    rows, messages = rows_and_messages
    for row, state, centreline in zip(
        rows, messages["/state"], messages["/centreline"], strict=True
    ):
        assert stamp_of(state.header) == row.stamp
        assert read_state(state) == row.state
        assert read_sigma(state) == row.sigma
        foot = centreline.pose.pose.position
        assert np.hypot(foot.x, foot.y) == pytest.approx(abs(row.state.distance), abs=1e-9)


def test_the_particles_of_the_bag_lie_about_the_state(rows_and_messages):
    rows, messages = rows_and_messages
    for row, message in zip(rows, messages["/particles"], strict=True):
        cloud = read_particles(message)
        assert cloud.shape == (200, 9)
        assert cloud[:, -1] @ cloud[:, 0] == pytest.approx(row.state.distance, abs=0.5)


def test_the_truth_of_the_recording_is_in_the_bag(rows_and_messages, dive):
    _, messages = rows_and_messages
    assert [read_state(truth) for truth in messages["/ground_truth"]] == [
        frame.truth for frame in dive
    ]


def test_rows_and_messages_without_a_claim_have_no_state(track, make_recording):
    folder, _ = track(make_recording(), given=GivenState.around(CableState(-20.0, 1.2, 5.0)))
    rows = read_estimates(folder / ESTIMATES)
    assert rows[0].status == "INITIALISING"
    assert rows[0].state is None
    assert rows[0].sigma is None
    assert None not in (rows[0].n_eff, rows[0].evidence, rows[0].hypotheses)
    messages = messages_of(folder)
    claimed = sum(row.status == "TRACKING" for row in rows)
    assert len(messages.get("/centreline", [])) == claimed
    assert len(messages["/state"][0].position) == 0
    assert len(messages["/particles"]) == 12


def test_the_same_recording_gives_the_same_bytes(track, make_recording):
    folders = [track(make_recording(), name=name)[0] for name in ("first", "second")]
    first, second = ((folder / ESTIMATES).read_bytes() for folder in folders)
    assert first == second


def test_times_are_measured_where_they_are_wanted(track, make_recording):
    timed, _ = track(make_recording(), name="timed", timing=True)
    plain, _ = track(make_recording(), name="plain")
    assert all(row.ms > 0 for row in read_estimates(timed / ESTIMATES))
    assert all(row.ms is None for row in read_estimates(plain / ESTIMATES))


def test_a_damaged_recording_keeps_the_frames_before(track, make_recording, dive):
    broken = RecordingError("dive: breaks off after frame 4; the frames before are used")
    folder, damage = track(make_recording(dive[:5], broken))
    assert damage is broken
    assert len(read_estimates(folder / ESTIMATES)) == 5


def test_a_frame_that_cannot_be_decoded_is_refused_and_the_next_is_tracked(
    track, make_recording, dive, undecodable
):
    frames = [*dive[:4], undecodable(dive[4]), *dive[5:]]
    folder, _ = track(make_recording(frames), given=GivenState.around(dive[0].truth))
    statuses = [row.status for row in read_estimates(folder / ESTIMATES)]
    assert statuses == ["TRACKING"] * 4 + ["REFUSED"] + ["TRACKING"] * 7
    messages = messages_of(folder)
    assert len(messages["/state"]) == len(messages["/tracker/frame_report"]) == 12
    assert len(messages["/particles"]) == 11
    assert len(messages["/state"][4].position) == 0
    report = messages["/tracker/frame_report"][4].status[0]
    assert report.message == "REFUSED"
    assert report.values[0].key == "event"
    assert report.values[0].value


def test_a_frame_with_the_stamp_of_the_one_before_is_refused(track, make_recording, dive):
    frames = [*dive[:3], dive[2], *dive[3:]]
    folder, _ = track(make_recording(frames), given=GivenState.around(dive[0].truth))
    statuses = [row.status for row in read_estimates(folder / ESTIMATES)]
    assert statuses[3] == "REFUSED"
    assert statuses.count("TRACKING") == 12


def test_a_track_starts_from_nothing_a_given_state_or_the_truth(make_recording, dive):
    recording = make_recording()
    assert given_state_for(recording, "random", DEFAULT_LIMITS) is None
    assert given_state_for(recording, "1,0.5,30,0", DEFAULT_LIMITS).state == CableState(
        1.0, 0.5, 30.0, 0.0
    )
    truth = dive[0].truth
    expected = CableState(truth.distance, truth.angle, truth.width, truth.skew)
    given = given_state_for(recording, "truth", DEFAULT_LIMITS)
    assert given.state == expected
    assert given.is_certain


def test_a_start_from_missing_truth_is_refused(make_recording, dive):
    unlabelled = [replace(dive[0], truth=None), *dive[1:]]
    with pytest.raises(ParameterError, match="no ground truth to start from"):
        given_state_for(make_recording(unlabelled), "truth", DEFAULT_LIMITS)
    with pytest.raises(RecordingError, match="holds no frames"):
        given_state_for(make_recording([]), "truth", DEFAULT_LIMITS)
