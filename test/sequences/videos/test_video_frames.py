from __future__ import annotations

import math
from pathlib import Path

import pytest

from cable_tracker.sequences.videos.video_frames import LONGEST_GAP, FrameClock, ffmpeg_name
from cable_tracker.stamps import FIRST_STAMP, NANOSECONDS, stamp_of_frame


def stamps_of(told, rate=25.0, **options):
    clock = FrameClock(rate, **options)
    return [clock.next_stamp(time) for time in told]


def steady(count, rate=25.0):
    return [stamp_of_frame(index, rate) for index in range(count)]


@pytest.mark.parametrize("rate", [1.0, 25.0, 30_000 / 1001, 60_000 / 1001, 240.0, 400.0])
@pytest.mark.parametrize("rounded", [round, math.floor])
def test_times_that_were_rounded_to_milliseconds_are_those_of_the_steady_rate(rate, rounded):
    told = [rounded(1000 * (index / rate)) for index in range(5000)]
    assert stamps_of(told, rate) == steady(5000, rate)


def test_stamps_count_from_the_first_time():
    assert stamps_of([10_000 + 40 * index for index in range(9)]) == steady(9)


def test_after_a_gap_the_steady_rate_goes_on_from_the_time_of_the_container():
    stamps = stamps_of([0.0, 40.0, 8040.0, 8080.0, 8121.0])
    after = [stamp - FIRST_STAMP for stamp in stamps]
    assert after == [0, 40_000_000, 8_040_000_000, 8_080_000_000, 8_120_000_000]


def test_a_mean_rate_that_no_frame_has_does_not_count():
    told = [0.0, 40.0, 80.0, 8080.0]
    after = [(stamp - FIRST_STAMP) / 1e6 for stamp in stamps_of(told, rate=1.42)]
    assert after == told


def test_a_rate_that_is_slightly_wrong_does_not_drift():
    told = [index * 1000 / 29.97 for index in range(3000)]
    stamps = stamps_of(told, rate=30.0)
    assert stamps[-1] - FIRST_STAMP == pytest.approx(told[-1] * 1e6, abs=2e6)
    assert stamps == sorted(set(stamps))


def test_a_time_that_repeats_is_not_believed():
    assert stamps_of([0.0, 40.0, 40.0, 120.0, 160.0]) == steady(5)


def test_times_that_run_backwards_or_are_missing_are_not_believed():
    assert stamps_of([0.0, 40.0, 80.0, 0.0, 40.0, math.nan, 0.0]) == steady(7)


def test_a_first_frame_without_a_time_is_at_the_beginning():
    told = [math.nan, 40.0, 80.0, 8080.0]
    assert [(stamp - FIRST_STAMP) / 1e6 for stamp in stamps_of(told)] == [0.0, *told[1:]]


def test_a_time_that_is_days_ahead_is_not_believed():
    assert stamps_of([0.0, LONGEST_GAP / 1e6 + 1e6, 80.0]) == steady(3)


def test_a_clock_that_is_steady_does_not_ask_the_container():
    assert stamps_of([0.0, 8000.0, 9000.0], is_steady=True) == steady(3)


def test_stamps_always_increase():
    told = [0.0, 41.9, 80.0, 80.1, 80.2, 1e5, 1e5 - 1, 1e5 + 0.01, 3.0, 1e5 + 500]
    stamps = stamps_of(told)
    assert stamps == sorted(set(stamps))
    assert stamps[5] - FIRST_STAMP == 100 * NANOSECONDS


def test_a_name_with_a_colon_is_not_taken_for_a_protocol():
    assert ffmpeg_name(Path("12:30:00.mp4")) == "./12:30:00.mp4"


def test_a_path_from_the_root_is_as_it_was():
    assert ffmpeg_name(Path("/dives/12:30:00.mp4")) == "/dives/12:30:00.mp4"
