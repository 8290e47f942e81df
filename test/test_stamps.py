from __future__ import annotations

from itertools import pairwise

import pytest

from cable_tracker.stamps import FIRST_STAMP, stamp_at, stamp_of_frame


def test_frames_without_times_begin_at_one_second():
    assert stamp_of_frame(0, 25.0) == FIRST_STAMP == 1_000_000_000


@pytest.mark.parametrize(
    ("index", "rate", "stamp"),
    [
        (1, 25.0, 1_040_000_000),
        (3, 30.0, 1_100_000_000),
        (1, 29.97, 1_033_366_700),
        (1_000_000, 25.0, 40_001_000_000_000),
        (1, 0.01, 101_000_000_000),
    ],
)
def test_stamps_follow_the_rate(index, rate, stamp):
    assert stamp_of_frame(index, rate) == stamp


def test_stamps_never_repeat():
    stamps = [stamp_of_frame(index, 59.94) for index in range(1000)]
    assert all(later > earlier for earlier, later in pairwise(stamps))


def test_seconds_count_from_frame_0():
    assert stamp_at(0.0) == FIRST_STAMP
    assert stamp_at(0.1234567891) == FIRST_STAMP + 123_456_789
