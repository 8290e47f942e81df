"""A recording of a target, followed in this process and watched."""

import threading

import numpy as np
import pytest

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.evaluation.targets.metrics import overlap
from cable_tracker.gui.recording_request import RecordingRequest
from cable_tracker.gui.recording_session import RecordingSession
from cable_tracker.gui.subject import TARGET
from cable_tracker.gui.tracking_desk import TrackingDesk, start_with_box
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.idle_status import WARMING_UP

TIMEOUT = 300.0
PARAMETERS = TargetParameters(particle_count=80, seed=4)


class Watched:
    """A session on a target."""

    def __init__(self, session):
        self.session = session
        self._changed = threading.Condition()
        session.listen(self._take)

    def _take(self, _snapshot):
        with self._changed:
            self._changed.notify_all()

    def at(self, frame, after=0):
        """Wait until a frame has been tracked, and return what was made of it."""

        def is_there():
            now = self.session.latest
            return (
                now is not None
                and now.frame == frame
                and now.status != WARMING_UP
                and now.number > after
            )

        with self._changed:
            assert self._changed.wait_for(is_there, TIMEOUT), self.session.latest
        return self.session.latest

    def go_to(self, frame):
        self.session.seek(frame)
        return self.at(frame)


@pytest.fixture
def watch(target_dive):
    """Return a function that watches the recording."""
    sessions = []

    def start(init="wait", parameters=PARAMETERS, **given):
        request = RecordingRequest(target_dive, init=init, **given)
        sessions.append(RecordingSession(request, parameters))
        return Watched(sessions[-1])

    yield start
    for session in sessions:
        session.close()


@pytest.fixture
def first_box(target_frames):
    return target_frames[0].box


def words(box):
    return ",".join(str(side) for side in box)


def test_a_target_that_is_marked_at_the_start_is_followed(watch, first_box, target_frames):
    watched = watch(words(first_box))
    assert watched.session.subject is TARGET
    watched.at(0)
    last = watched.go_to(10)
    assert last.status == "TRACKING"
    assert last.image.shape == (240, 320, 3)
    assert overlap(last.box, target_frames[10].box) > 0.5
    assert last.truth == target_frames[10].box
    assert last.cloud.shape == (80, 7)
    assert last.state[2] == pytest.approx(1.0, abs=0.3)
    assert len(last.outline) > 8


def test_going_back_gives_the_same_belief_again(watch, first_box):
    watched = watch(words(first_box))
    watched.at(0)
    once = watched.go_to(6)
    watched.go_to(9)
    again = watched.go_to(6)
    assert np.array_equal(once.cloud, again.cloud)
    assert np.array_equal(once.state, again.state)


def test_without_a_mark_nothing_is_claimed_until_one_is_drawn(watch, first_box):
    watched = watch()
    nothing = watched.at(0)
    assert (nothing.status, nothing.box) == ("INITIALISING", None)
    start_with_box(watched.session, first_box[2:], first_box[:2])
    found = watched.at(0, after=nothing.number)
    assert found.status == "TRACKING"
    assert overlap(found.box, first_box) > 0.5


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


def test_a_desk_of_targets_opens_recordings_of_targets(target_dive, first_box):
    desk = TrackingDesk(None, RecordingRequest(target_dive), PARAMETERS)
    try:
        assert set(desk.references) == {"default", "thesis", "docking", "diver"}
        desk.open(RecordingRequest(target_dive, init=words(first_box)))
        watched = Watched(desk.need_session())
        assert watched.at(0).box == desk.present_box()
        assert desk.present_state() is None
    finally:
        desk.close()
