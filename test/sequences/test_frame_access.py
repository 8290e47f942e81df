import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.sequences.frame_access import BEYOND_ALL, FrameAccess
from cable_tracker.sequences.source_base import ChosenRecording, Source, damage

PIXELS = bytes(12)


class Numbers(Source):
    """Frames whose stamp is their number; counts how often it was begun, and what it gave."""

    def __init__(self, path, count, *, broken=False):
        super().__init__(ChosenRecording(path))
        self._count, self._broken = count, broken
        self.readings = self.handed_out = 0

    def _read(self, start):
        self.readings += 1
        for index in range(start, self._count):
            image = RawImage("mono8", 3, 4, 4, False, memoryview(PIXELS))
            self.handed_out += 1
            yield Frame(index, index, image)
        if self._broken:
            raise damage(self.path, self._count, "cut off")


@pytest.fixture
def numbers(tmp_path):
    return Numbers(tmp_path, 10)


@given(st.lists(st.integers(0, 9)), st.integers(1, 200))
def test_any_frame_comes_at_any_time(order, kept):
    frames = FrameAccess(Numbers("", 10), kept)
    assert [frames.frame(index).stamp for index in order] == order


def test_frames_in_order_are_read_once(numbers):
    frames = FrameAccess(numbers, kept_bytes=1)
    for index in range(10):
        frames.frame(index)
    assert numbers.readings == 1


def test_kept_frames_need_no_reading(numbers):
    frames = FrameAccess(numbers)
    for index in (*range(10), 3, 0, 8):
        frames.frame(index)
    assert numbers.readings == 1


def test_no_more_is_kept_than_allowed(numbers):
    frames = FrameAccess(numbers, kept_bytes=2 * len(PIXELS))
    for index in (*range(6), 4):
        frames.frame(index)
    assert numbers.readings == 1
    frames.frame(3)
    assert numbers.readings == 2


def test_the_number_of_frames_is_known_at_the_end(numbers):
    frames = FrameAccess(numbers)
    assert frames.count is None
    with pytest.raises(IndexError):
        frames.frame(10)
    assert frames.count == 10
    assert frames.frame(9).stamp == 9


def test_the_end_is_found_in_one_reading_which_keeps_the_last_frame(numbers):
    frames = FrameAccess(numbers, kept_bytes=1)
    frames.frame(0)
    with pytest.raises(IndexError):
        frames.frame(BEYOND_ALL)
    assert frames.count == 10
    assert frames.frame(9).stamp == 9
    assert (numbers.readings, numbers.handed_out) == (1, 10)


def test_the_end_is_found_after_going_back_too(numbers):
    frames = FrameAccess(numbers, kept_bytes=1)
    for index in (5, 2):
        frames.frame(index)
    with pytest.raises(IndexError):
        frames.frame(BEYOND_ALL)
    assert frames.count == 10


def test_a_far_frame_is_reached_without_those_between(numbers):
    frames = FrameAccess(numbers, kept_bytes=1)
    frames.frame(0)
    frames.frame(9)
    assert numbers.handed_out == 2


def test_the_end_is_found_also_from_beyond_it(numbers):
    frames = FrameAccess(numbers)
    frames.frame(2)
    with pytest.raises(IndexError, match="has 10"):
        frames.frame(500)
    assert frames.count == 10


def test_a_negative_frame_number_is_refused(numbers):
    with pytest.raises(IndexError):
        FrameAccess(numbers).frame(-1)


def test_damage_is_reported_and_the_frames_before_it_remain(tmp_path):
    frames = FrameAccess(Numbers(tmp_path, 4, broken=True))
    with pytest.raises(RecordingError, match="cut off"):
        frames.frame(4)
    assert frames.damage is not None
    assert frames.frame(3).stamp == 3
    with pytest.raises(RecordingError, match="cut off"):
        frames.frame(7)


class Holed(Source):
    """Twenty frames of which one cannot be read; those before a start are passed over unread."""

    def __init__(self, path, hole):
        super().__init__(ChosenRecording(path))
        self._hole = hole

    def _read(self, start):
        for index in range(start, 20):
            if index == self._hole:
                raise damage(self.path, index, "a hole")
            yield Frame(index, index, RawImage("mono8", 3, 4, 4, False, memoryview(PIXELS)))


def test_a_hole_takes_no_frame_away_that_was_read(tmp_path):
    frames = FrameAccess(Holed(tmp_path, 5), kept_bytes=1)
    for index in (0, 15, 4):
        frames.frame(index)
    for _ in range(2):
        with pytest.raises(RecordingError, match="a hole"):
            frames.frame(5)
    # From the frame before the hole on, too, where reading on would be less work.
    for index in (4, 8, 15, 19):
        assert frames.frame(index).stamp == index
    assert frames.count is None
    assert frames.damage is None
    with pytest.raises(IndexError, match="has 20"):
        frames.frame(20)


def test_frames_that_are_gone_take_none_away_that_were_read(numbers):
    frames = FrameAccess(numbers, kept_bytes=1)
    frames.frame(8)
    numbers._count = 6
    with pytest.raises(RecordingError, match="frame 7 is no longer there"):
        frames.frame(7)
    assert frames.frame(5).stamp == 5
    with pytest.raises(IndexError):
        frames.frame(BEYOND_ALL)
    assert frames.count == 9
