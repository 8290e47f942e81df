from types import SimpleNamespace

import pytest

from cable_tracker.errors import FrameError, GuiError
from cable_tracker.gui.session.tracked_recording import LONGEST_RUN, TrackedRecording
from cable_tracker.tracking.status import DISABLED, REFUSED, WARMING_UP

LAST = 99
REFUSED_FRAME = 50


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
