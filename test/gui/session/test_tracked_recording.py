from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import FrameError, GuiError
from cable_tracker.gui.session import tracked_recording
from cable_tracker.gui.session.tracked_recording import (
    FIRST_INTERVAL,
    LARGEST_COUNT,
    LONGEST_RUN,
    TrackedRecording,
    TrackerMemory,
)
from cable_tracker.trackers import CableTracker
from cable_tracker.tracking.status import DISABLED, REFUSED, WARMING_UP

LAST = 99
REFUSED_FRAME = 50

FRAME_TIME = 40_000_000
PARAMETERS = TrackerParameters(filter="bootstrap", observation="responses", particle_count=20)


class Frames:
    """A recording of 100 frames."""

    count = LAST + 1

    @staticmethod
    def frame(index):
        if not 0 <= index <= LAST:
            raise IndexError(index)
        return SimpleNamespace(index=index)


class Path:
    """Follows by noting which frames it has been given since it knew nothing."""

    particles = None

    def __init__(self, way=()):
        self.way = way

    def copy(self):
        return Path(self.way)

    def reset(self):
        self.way = ()

    def begin(self):
        self.way = ("start",)

    def initialise(self, start):
        self.way = (start,)

    def decode(self, frame):
        if frame.index == REFUSED_FRAME:
            raise FrameError("no picture")

    def close(self):
        pass

    def follow(self, frame, number):
        self.way += (frame.index,)
        return number, frame.index, self.way

    def show(self, frame, number, status, reason=""):
        return number, frame.index, status


@pytest.fixture
def run():
    """A recording at its first frame, and what has been published."""
    shown = []
    tracked = TrackedRecording(Frames(), Path(), shown.append)
    tracked.show_first()
    assert shown == [(1, 0, WARMING_UP)]
    assert tracked.go_to(0, never)
    return tracked, shown


def never(is_target):
    return False


def test_frames_on_the_way_are_tracked_and_only_the_last_is_shown(run):
    tracked, shown = run
    assert tracked.go_to(LONGEST_RUN, never)
    assert shown[-1] == (3, LONGEST_RUN, ("start", *range(LONGEST_RUN + 1)))


def test_far_away_the_tracker_starts_anew_and_comes_back_as_it_was(run):
    tracked, shown = run
    assert tracked.go_to(LONGEST_RUN + 1, never)
    assert shown[-1][2] == (LONGEST_RUN + 1,)
    assert tracked.go_to(0, never)
    assert shown[-1][2] == ("start", 0)


def test_behind_the_end_it_is_the_last_frame(run):
    tracked, shown = run
    assert tracked.go_to(LAST + 9, never)
    assert (tracked.position, shown[-1][1]) == (LAST, LAST)
    assert not tracked.go_to(LAST + 9, never)
    assert not tracked.go_to(LAST, never)


def test_going_back_to_a_refused_frame_keeps_what_was_known_before_it(run):
    tracked, shown = run
    for frame in range(1, REFUSED_FRAME + 2):
        tracked.go_to(frame, never)
    before = shown[-1]
    tracked.go_to(REFUSED_FRAME, never)
    assert shown[-1][1:] == (REFUSED_FRAME, REFUSED)
    tracked.go_to(REFUSED_FRAME + 1, never)
    assert shown[-1][1:] == before[1:]


def test_it_stops_on_the_way_where_another_frame_is_wanted(run):
    tracked, shown = run
    count = len(shown)
    asked = []

    def after_three(is_target):
        asked.append(is_target)
        return len(asked) > 3

    assert not tracked.go_to(10, after_three)
    assert (tracked.position, len(shown), asked) == (3, count, [False] * 4)


def test_what_is_still_is_tracked_again_after_a_reset(run):
    tracked, shown = run
    tracked.go_to(2, never)
    tracked.reset(is_still=True)
    assert shown[-1][1:] == (2, (2,))
    count = len(shown)
    tracked.reset(is_still=False)
    assert len(shown) == count
    tracked.go_to(3, never)
    assert shown[-1][1:] == (3, (3,))


@pytest.mark.parametrize("is_still", [True, False])
def test_what_is_drawn_while_the_tracker_is_off_is_refused_in_words(run, is_still):
    tracked, shown = run
    tracked.enable(False, is_still=True)
    count = len(shown)
    with pytest.raises(GuiError, match="switch it on first"):
        tracked.initialise("here", is_still=is_still)
    assert len(shown) == count
    tracked.enable(True, is_still=True)
    tracked.initialise("here", is_still=True)
    assert shown[-1][1:] == (0, ("here", 0))


def test_a_disabled_tracker_takes_no_frames(run):
    tracked, shown = run
    tracked.enable(False, is_still=False)
    tracked.go_to(7, never)
    assert shown[-1][1:] == (7, DISABLED)
    tracked.enable(True, is_still=True)
    assert shown[-1][1:] == (7, (7,))


def draw(tracked, is_still):
    tracked.initialise("drawn", is_still=is_still)


def reset(tracked, is_still):
    tracked.reset(is_still=is_still)


def switch_off_and_on(tracked, is_still):
    tracked.enable(False, is_still=is_still)
    tracked.enable(True, is_still=is_still)


ACTS = pytest.mark.parametrize("act", [draw, reset, switch_off_and_on])


@ACTS
@pytest.mark.parametrize("is_still", [True, False])
@pytest.mark.parametrize("back", [29, 20, 0])
def test_what_the_user_did_is_kept_when_one_goes_back_and_plays_on(run, act, is_still, back):
    tracked, shown = run
    for frame in range(1, 31):
        tracked.go_to(frame, never)
    act(tracked, is_still)
    tracked.go_to(31, never)
    believed = shown[-1][1:]
    assert believed[1][-1] == 31
    assert 29 not in believed[1]
    for _ in range(2):
        tracked.go_to(back, never)
        for frame in range(back + 1, 32):
            tracked.go_to(frame, never)
        assert shown[-1][1:] == believed


@ACTS
def test_what_the_user_did_is_kept_on_the_way_to_a_frame_further_on(run, act):
    tracked, shown = run
    tracked.go_to(10, never)
    act(tracked, is_still=True)
    tracked.go_to(12, never)
    tracked.go_to(9, never)
    tracked.go_to(20, never)
    assert shown[-1][2][-11:] == tuple(range(10, 21))
    assert 9 not in shown[-1][2]


def test_what_was_drawn_is_kept_where_the_way_on_was_interrupted_before_it_was_tracked(run):
    tracked, shown = run
    tracked.go_to(10, never)
    draw(tracked, is_still=False)
    tracked.go_to(13, lambda is_target: True)
    tracked.go_to(14, never)
    believed = shown[-1][1:]
    assert believed[1] == ("drawn", 11, 12, 13, 14)
    for frame in (9, 10, 11, 12, 13, 14):
        tracked.go_to(frame, never)
    assert shown[-1][1:] == believed


def test_a_frame_that_was_drawn_on_and_left_by_a_jump_is_an_ordinary_one(run):
    tracked, shown = run
    draw(tracked, is_still=False)
    tracked.go_to(60, never)
    tracked.go_to(1, never)
    tracked.go_to(0, never)
    tracked.go_to(1, never)
    assert shown[-1][2] == ("start", 0, 1)


def picture(number):
    return np.random.default_rng(number).integers(0, 255, (48, 64), dtype=np.uint8)


class Run:
    """Tracks noise, and remembers what it believed."""

    def __init__(self):
        self.tracker = CableTracker(PARAMETERS)
        self.memory = TrackerMemory()

    def track(self, frames):
        believed = {}
        for frame in frames:
            self.memory.note(frame, self.tracker)
            self.tracker.process(picture(frame), (frame + 1) * FRAME_TIME)
            believed[frame] = self.tracker.particles.states.copy()
        return believed

    def go_to(self, frame):
        self.tracker, first = self.memory.recall(frame)
        return self.track(range(first, frame + 1))[frame]


@pytest.fixture
def unbroken():
    return Run()


def test_every_frame_that_was_tracked_comes_back_as_it_was(unbroken):
    believed = unbroken.track(range(3 * FIRST_INTERVAL + 4))
    for frame in (0, FIRST_INTERVAL - 1, FIRST_INTERVAL, 70, 3, 3 * FIRST_INTERVAL + 3):
        assert np.array_equal(unbroken.go_to(frame), believed[frame])


def test_going_back_and_on_forgets_nothing_of_what_comes_later(unbroken):
    believed = unbroken.track(range(100))
    unbroken.go_to(40)
    unbroken.track(range(41, 60))
    assert np.array_equal(unbroken.go_to(95), believed[95])


def test_a_frame_that_was_never_tracked_cannot_be_recalled(unbroken):
    unbroken.track(range(10))
    assert unbroken.memory.recall(10) is None
    assert unbroken.memory.recall(5) is not None


def test_after_a_jump_both_pieces_are_known_and_nothing_between(unbroken):
    early = unbroken.track(range(10))
    unbroken.memory.interrupt()
    unbroken.tracker.reset()
    late = unbroken.track(range(50, 60))
    assert unbroken.memory.recall(30) is None
    assert np.array_equal(unbroken.go_to(5), early[5])
    assert np.array_equal(unbroken.go_to(55), late[55])


def test_a_belief_that_the_user_gives_replaces_what_came_after(unbroken):
    before = unbroken.track(range(60))
    unbroken.go_to(30)
    unbroken.tracker.initialise(GivenState.around(CableState(3.0, 0.1, 12.0)))
    unbroken.memory.forget_from(31)
    after = unbroken.track(range(31, 50))
    assert not np.array_equal(after[31], before[31])
    assert unbroken.memory.recall(50) is None
    assert np.array_equal(unbroken.go_to(45), after[45])
    assert np.array_equal(unbroken.go_to(30), before[30])


def test_the_number_is_bounded_and_nothing_is_lost(unbroken, monkeypatch):
    few = 16
    monkeypatch.setattr(tracked_recording, "LARGEST_COUNT", few)
    count = (few + 5) * FIRST_INTERVAL
    believed = unbroken.track(range(count))
    assert len(unbroken.memory._kept) <= few < count / FIRST_INTERVAL
    for frame in (0, 60, count // 2 + 7, count - 1):
        assert np.array_equal(unbroken.go_to(frame), believed[frame])


def test_many_jumps_are_bounded_too(unbroken):
    for start in range(0, 10 * (LARGEST_COUNT + 10), 10):
        unbroken.memory.interrupt()
        unbroken.tracker.reset()
        unbroken.track((start,))
    assert len(unbroken.memory._kept) <= LARGEST_COUNT


def test_after_many_jumps_what_is_tracked_next_is_remembered_as_closely(unbroken):
    for start in range(0, 10 * (LARGEST_COUNT + 10), 10):
        unbroken.memory.interrupt()
        unbroken.track((start,))
    first = 10 * (LARGEST_COUNT + 10)
    unbroken.memory.interrupt()
    unbroken.track(range(first, first + 3 * FIRST_INTERVAL))
    _, nearest = unbroken.memory.recall(first + 3 * FIRST_INTERVAL - 1)
    assert nearest == first + 2 * FIRST_INTERVAL
