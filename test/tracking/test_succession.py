import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cable_tracker.errors import FrameError
from cable_tracker.tracking.succession import (
    FrameMark,
    Succession,
    check_frame,
    check_levels,
    is_out_of_order,
    joined_events,
    succession,
)

FIRST = FrameMark((320, 240), 1_000_000_000)


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((15, 320), np.uint8), "320x15 px is too small"),
        (np.zeros((320, 15, 3), np.uint8), "15x320 px is too small"),
        (np.zeros((20, 20, 3), np.float64), "float64"),
        (np.full((20, 20, 3), np.nan, np.float32), "NaN"),
        (np.full((20, 20), np.inf, np.float32), "infinite"),
    ],
)
def test_bad_levels_are_refused(image, words):
    with pytest.raises(FrameError, match=words):
        check_levels(image)


@pytest.mark.parametrize("shape", [(16, 16), (16, 16, 3)])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_small_pictures_are_accepted(shape, dtype):
    check_levels(np.zeros(shape, dtype))


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((240, 320, 3), np.uint8), r"not \(240, 320, 3\)"),
        (np.zeros(320, np.uint8), r"not \(320,\)"),
        (np.zeros((0, 0), np.uint8), "0x0 px is too small"),
        (np.zeros((15, 320), np.uint8), "320x15 px is too small"),
        (np.zeros((40000, 20), np.uint8), "20x40000 px is too large"),
        (np.zeros((20, 20), np.float64), "float64"),
        (np.zeros((20, 20), np.uint16), "uint16"),
        ([[0, 1], [2, 3]], "a NumPy array, not a list"),
        (np.full((20, 20), np.nan, np.float32), "NaN"),
        (np.full((20, 20), np.inf, np.float32), "infinite"),
        (np.full((20, 20), -3e38, np.float32), "between -1e\\+09 and 1e\\+09"),
    ],
)
def test_a_bad_picture_is_refused_in_one_line(image, words):
    with pytest.raises(FrameError, match=words) as caught:
        check_frame(image)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_small_grey_pictures_are_accepted(dtype):
    check_frame(np.zeros((16, 16), dtype))


def following(seconds: float, size: tuple[int, int] = (320, 240)) -> Succession:
    return succession(FIRST, FrameMark(size, FIRST.stamp + round(seconds * 1e9)), maximum_gap=5.0)


def test_the_first_frame_counts_as_one_at_the_reference_rate():
    assert succession(None, FIRST, 5.0) == Succession(dt=0.04, event="")


def test_a_frame_in_time_goes_on():
    assert following(0.25) == Succession(dt=0.25, event="")
    assert following(5.0) == Succession(dt=5.0, event="")


@pytest.mark.parametrize(
    ("seconds", "size", "event"),
    [
        (0.04, (640, 480), "the image size changed from 320x240 to 640x480"),
        (-0.201, (320, 240), "time went back by 0.201 s"),
        (-0.5, (320, 240), "time went back by 0.500 s"),
        (-3600.0, (320, 240), "time went back by 3600.000 s"),
        (7200.0, (320, 240), "no frame for 7200.000 s"),
        (5.001, (320, 240), "no frame for 5.001 s"),
    ],
)
def test_a_gap_or_another_size_restarts_tracking_with_the_reason(seconds, size, event):
    is_same = size == (320, 240)
    assert following(seconds, size) == Succession(0.04, event, is_same)


def test_the_same_time_again_is_refused():
    with pytest.raises(FrameError, match=r"1\.000000000 s is that of the frame before"):
        following(0.0)


@pytest.mark.parametrize("step", [1, 40, 999])
def test_stamps_in_other_units_than_nanoseconds_are_refused(step):
    with pytest.raises(FrameError, match=rf"only {step} ns .* stamps are in nanoseconds"):
        succession(FIRST, FrameMark(FIRST.size, FIRST.stamp + step), maximum_gap=5.0)


@pytest.mark.parametrize(("seconds", "late"), [(-1e-9, "0.000"), (-0.04, "0.040"), (-0.2, "0.200")])
def test_a_frame_that_was_overtaken_is_refused(seconds, late):
    with pytest.raises(FrameError, match=rf"{late} s older than the one before: out of order"):
        following(seconds)


@given(st.integers(-300_000_000, 300_000_000))
@example(-200_000_000)
@example(1000)
def test_frames_out_of_order_are_exactly_the_refused_ones(step):
    def is_refused() -> bool:
        try:
            succession(FIRST, FrameMark(FIRST.size, FIRST.stamp + step), maximum_gap=5.0)
        except FrameError:
            return True
        return False

    assert is_out_of_order(FIRST.stamp, FIRST.stamp + step) == is_refused()


@pytest.mark.parametrize("stamp", [math.nan, math.inf, -math.inf, 2**63, None, "3"])
@pytest.mark.parametrize("before", [None, FIRST])
def test_a_stamp_that_is_no_time_is_refused(before, stamp):
    with pytest.raises(FrameError, match="is no time; give whole nanoseconds"):
        succession(before, FrameMark((320, 240), stamp), 5.0)


def test_events_are_joined_but_for_those_that_say_nothing():
    assert joined_events("no frame for 9 s", "", "it was marked anew") == (
        "no frame for 9 s; it was marked anew"
    )
    assert joined_events("", "") == ""
