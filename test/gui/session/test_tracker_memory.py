import numpy as np
import pytest

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.gui.session import tracker_memory
from cable_tracker.gui.session.tracker_memory import FIRST_INTERVAL, LARGEST_COUNT, TrackerMemory
from cable_tracker.trackers import CableTracker

FRAME_TIME = 40_000_000
PARAMETERS = TrackerParameters(filter="bootstrap", observation="responses", particle_count=20)


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
def run():
    return Run()


def test_every_frame_that_was_tracked_comes_back_as_it_was(run):
    believed = run.track(range(3 * FIRST_INTERVAL + 4))
    for frame in (0, FIRST_INTERVAL - 1, FIRST_INTERVAL, 70, 3, 3 * FIRST_INTERVAL + 3):
        assert np.array_equal(run.go_to(frame), believed[frame])


def test_going_back_and_on_forgets_nothing_of_what_comes_later(run):
    believed = run.track(range(100))
    run.go_to(40)
    run.track(range(41, 60))
    assert np.array_equal(run.go_to(95), believed[95])


def test_a_frame_that_was_never_tracked_cannot_be_recalled(run):
    run.track(range(10))
    assert run.memory.recall(10) is None
    assert run.memory.recall(5) is not None


def test_after_a_jump_both_pieces_are_known_and_nothing_between(run):
    early = run.track(range(10))
    run.memory.interrupt()
    run.tracker.reset()
    late = run.track(range(50, 60))
    assert run.memory.recall(30) is None
    assert np.array_equal(run.go_to(5), early[5])
    assert np.array_equal(run.go_to(55), late[55])


def test_a_belief_that_the_user_gives_replaces_what_came_after(run):
    before = run.track(range(60))
    run.go_to(30)
    run.tracker.initialise(GivenState.around(CableState(3.0, 0.1, 12.0)))
    run.memory.forget_from(31)
    after = run.track(range(31, 50))
    assert not np.array_equal(after[31], before[31])
    assert run.memory.recall(50) is None
    assert np.array_equal(run.go_to(45), after[45])
    assert np.array_equal(run.go_to(30), before[30])


def test_the_number_is_bounded_and_nothing_is_lost(run, monkeypatch):
    few = 16
    monkeypatch.setattr(tracker_memory, "LARGEST_COUNT", few)
    count = (few + 5) * FIRST_INTERVAL
    believed = run.track(range(count))
    assert len(run.memory._kept) <= few < count / FIRST_INTERVAL
    for frame in (0, 60, count // 2 + 7, count - 1):
        assert np.array_equal(run.go_to(frame), believed[frame])


def test_many_jumps_are_bounded_too(run):
    for start in range(0, 10 * (LARGEST_COUNT + 10), 10):
        run.memory.interrupt()
        run.tracker.reset()
        run.track((start,))
    assert len(run.memory._kept) <= LARGEST_COUNT


def test_after_many_jumps_what_is_tracked_next_is_remembered_as_closely(run):
    for start in range(0, 10 * (LARGEST_COUNT + 10), 10):
        run.memory.interrupt()
        run.track((start,))
    first = 10 * (LARGEST_COUNT + 10)
    run.memory.interrupt()
    run.track(range(first, first + 3 * FIRST_INTERVAL))
    _, nearest = run.memory.recall(first + 3 * FIRST_INTERVAL - 1)
    assert nearest == first + 2 * FIRST_INTERVAL
