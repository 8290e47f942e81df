import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.benchmark.footage import Footage, FrameLoop, footage


@given(st.integers(1, 9), st.integers(0, 100))
def test_the_frames_go_forwards_and_backwards_without_a_jump(count, number):
    shown = Footage(tuple(np.zeros((1, 1), np.uint8) for _ in range(count)), ())
    here, there = shown.index_at(number), shown.index_at(number + 1)
    assert 0 <= here < count
    assert abs(here - there) == (1 if count > 1 else 0)
    assert shown.index_at(number + shown.period) == here


def test_a_truth_grows_with_the_frame_and_has_no_rates():
    (truth,), (wide,) = (footage(1, size).truths for size in ((320, 240), (640, 480)))
    assert wide == truth.scaled(2.0) == wide.at_rest()


class Listener:
    """A method that only remembers what it was told and shown."""

    def __init__(self):
        self.told, self.stamps = [], []

    def initialise(self, given):
        self.told.append((len(self.stamps), given.state))

    def process(self, image, stamp):
        self.stamps.append(stamp)
        return type("Answer", (), {"is_claimed": True})


def test_a_loop_tells_the_truth_whenever_the_first_frame_comes_back(shown):
    listener = Listener()
    loop = FrameLoop(listener, shown)
    for _ in range(2 * shown.period + 1):
        loop()
    assert [place for place, _ in listener.told] == [0, shown.period, 2 * shown.period]
    assert {state for _, state in listener.told} == {shown.truths[0]}
    assert set(np.diff(listener.stamps)) == {40_000_000}
    assert loop.frames == loop.claimed == 2 * shown.period + 1
