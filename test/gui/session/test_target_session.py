"""A recording of a target, followed in this process and watched."""

from dataclasses import replace

import numpy as np
import pytest
from chase_bag import write_chase_bag
from watched_session import Watched

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.evaluation.targets.comparison import overlap
from cable_tracker.gui.session.recording_session import RecordingRequest, RecordingSession
from cable_tracker.gui.subject import TARGET
from cable_tracker.gui.tracking.shared_session import SharedSession, start_with_box
from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.metric.targets.recorded_target import recorded_target
from cable_tracker.offline.results import WantedResults, follow_all
from cable_tracker.offline.target_folder import TargetFolder
from cable_tracker.offline.track_target import follow_frame
from cable_tracker.sequences.source import open_chosen
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker

PARAMETERS = TargetParameters(particle_count=80, seed=4)
TURNING_LENGTH = 32
TABLE_ONLY = WantedResults(video=False, bag=False, pictures=False)


@pytest.fixture
def watch(target_dive):
    """Return a function that watches the recording."""
    sessions = []

    def start(init="wait", parameters=PARAMETERS, path=target_dive, **given):
        request = RecordingRequest(path, init=init, **given)
        sessions.append(RecordingSession(request, parameters))
        return Watched(sessions[-1])

    yield start
    for session in sessions:
        session.close()


@pytest.fixture
def first_box(target_frames):
    return target_frames[0].box


@pytest.fixture(scope="module")
def turning_dive(tmp_path_factory):
    """Return a bag of a vehicle that turns, with calibration and odometry, and the first box."""
    path = tmp_path_factory.mktemp("recordings") / "turning"
    ((box, _), *_) = write_chase_bag(path, TURNING_LENGTH)
    return path, box


def words(box):
    return ",".join(str(side) for side in box)


def test_a_target_that_is_marked_at_the_start_is_followed(watch, first_box, target_frames):
    watched = watch(words(first_box))
    assert watched.session.subject is TARGET
    watched.at(0)
    last = watched.go_to(10)
    assert last.row.status == "TRACKING"
    assert last.image.shape == (240, 320, 3)
    assert overlap(last.row.claim.box, target_frames[10].box) > 0.5
    assert last.truth == target_frames[10].box
    assert last.cloud.shape == (80, 7)
    assert last.row.claim.state[2] == pytest.approx(1.0, abs=0.3)
    assert len(last.outline) > 8


def test_going_back_gives_the_same_belief_again(watch, first_box):
    watched = watch(words(first_box))
    watched.at(0)
    once = watched.go_to(6)
    watched.go_to(9)
    again = watched.go_to(6)
    assert np.array_equal(once.cloud, again.cloud)
    assert replace(once.row, ms=None) == replace(again.row, ms=None)


def rows_of_command(path, box, folder):
    tracker = TargetTracker(PARAMETERS)
    tracker.initialise(TargetStart.from_box(*box))
    with (
        open_chosen(RecordingRequest(path)) as source,
        recorded_target(recorded_vehicle(source)) as instruments,
        TargetFolder(folder, timing=False, wanted=TABLE_ONLY) as results,
    ):
        follow_all(
            source.frames(), lambda frame: follow_frame(frame, tracker, results, instruments)
        )
        return list(results.rows)


def test_turns_of_the_camera_are_taken_out_as_by_the_command_target(watch, turning_dive, tmp_path):
    path, box = turning_dive
    rows = rows_of_command(path, box, tmp_path / "out")
    played = watch(words(box), path=path).play_to_the_end()
    assert len(rows) == TURNING_LENGTH
    for row in rows:
        assert replace(played[row.frame].row, ms=None) == row


def test_going_back_takes_the_same_turns_of_the_camera_out_again(watch, turning_dive):
    path, box = turning_dive
    watched = watch(words(box), path=path)
    played = watched.play_to_the_end()
    for frame in (28, 20, 0, TURNING_LENGTH - 1):
        again = watched.go_to(frame)
        assert np.array_equal(again.cloud, played[frame].cloud)


def test_a_closed_session_reads_no_more_of_the_instruments(watch, turning_dive):
    path, box = turning_dive
    watched = watch(words(box), path=path)
    watched.at(0)
    feed = watched.session._tracked.tracker._instruments._feed
    watched.session.close()
    assert feed._messages.gi_frame is None


def test_without_a_mark_nothing_is_claimed_until_one_is_drawn(watch, first_box):
    watched = watch()
    nothing = watched.at(0)
    assert (nothing.row.status, nothing.row.claim) == ("INITIALISING", None)
    start_with_box(watched.session, first_box[2:], first_box[:2])
    found = watched.at(0, after=nothing.number)
    assert found.row.status == "TRACKING"
    assert overlap(found.row.claim.box, first_box) > 0.5


def test_a_detector_proposes_what_to_follow(watch):
    watched = watch("detect")
    # Of this start alone: the next recording is opened with the user's own parameters.
    assert watched.session.parameters()["detector"] == "none"
    watched.at(0)


@pytest.mark.parametrize("corners", [(5, 5, 6, 6), (900, 5, 950, 60)])
def test_a_box_that_the_picture_cannot_hold_is_refused(watch, corners):
    watched = watch()
    watched.at(0)
    with pytest.raises(FrameError):
        watched.session.initialise(TargetStart.from_box(*corners))


@pytest.mark.parametrize("init", ["random", "1,2,3", "1,2,30,40;50,60,90,99"])
def test_a_start_that_is_none_is_refused(watch, init):
    with pytest.raises(ParameterError):
        watch(init)


def test_labels_that_do_not_fit_are_refused(watch, tmp_path):
    (tmp_path / "b.txt").write_text("none.png 1 2 3 4\n")
    with pytest.raises(RecordingError, match="no frame of"):
        watch(truth=tmp_path / "b.txt")


def test_parameters_of_a_target_are_changed_all_or_none(watch):
    watched = watch()
    watched.at(0)
    with pytest.raises(ParameterError):
        watched.session.change({"particle_count": 50, "sharpness": -1.0})
    assert watched.session.parameters()["particle_count"] == 80
    watched.session.change({"particle_count": 50})
    assert watched.session.parameters()["particle_count"] == 50


def test_a_shared_session_of_targets_opens_recordings_of_targets(target_dive, first_box):
    shared = SharedSession(RecordingRequest(target_dive), PARAMETERS)
    try:
        assert set(shared.references) == {"default", "thesis", "docking", "diver"}
        shared.open(RecordingRequest(target_dive, init=words(first_box)))
        watched = Watched(shared.need_session())
        assert watched.at(0).row.claim.box == shared.present_box()
        assert shared.present_state() is None
    finally:
        shared.close()
