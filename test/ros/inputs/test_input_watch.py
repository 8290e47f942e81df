from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.node_parameter_tables import CameraRuntimeParameters
from cable_tracker.ros.health.diagnostics import FROZEN_INPUT, STALE_INPUT
from cable_tracker.ros.inputs.input_watch import InputWatch, same

SECOND = 1_000_000_000


def watch(frozen_timeout: float = 2.0, maximum_gap: float = math.inf) -> InputWatch:
    made = InputWatch(100.0)
    made.configure(CameraRuntimeParameters(frozen_timeout=frozen_timeout), maximum_gap)
    return made


def test_silence_is_reported_once_and_ends_with_a_usable_frame() -> None:
    watched = watch()
    assert not watched.falls_silent(101.0)
    assert watched.falls_silent(101.1)
    assert not watched.falls_silent(105.0)
    assert watched.status == STALE_INPUT
    watched.note_usable(106.0)
    assert watched.status == ""


def test_silence_is_counted_from_the_restart() -> None:
    watched = watch()
    watched.restart(200.0)
    assert not watched.falls_silent(200.9)
    assert watched.falls_silent(201.1)


def test_the_same_picture_for_long_is_frozen_until_it_changes() -> None:
    watched, picture = watch(), np.full((20, 30), 7, np.uint8)
    assert not watched.is_frozen(picture, SECOND)
    assert not watched.is_frozen(picture.copy(), 2 * SECOND)
    assert watched.is_frozen(picture.copy(), 3 * SECOND)
    assert watched.note_frozen(is_frozen=True)
    assert not watched.note_frozen(is_frozen=True)
    assert watched.status == FROZEN_INPUT
    assert not watched.is_frozen(picture + 1, 4 * SECOND)
    watched.note_frozen(is_frozen=False)
    assert watched.status == ""


def test_colour_pictures_are_watched_too() -> None:
    watched, picture = watch(), np.zeros((20, 30, 3), np.uint8)
    other = picture.copy()
    other[1, 1, 2] = 1
    assert not watched.is_frozen(picture, SECOND)
    assert not watched.is_frozen(other, 5 * SECOND)


def test_a_timeout_of_zero_never_freezes_but_measures_the_time() -> None:
    watched, picture = watch(frozen_timeout=0.0), np.zeros((20, 30), np.uint8)
    assert not any(watched.is_frozen(picture, index * SECOND) for index in range(9))
    assert watched.picture is picture
    assert watched.same_for == 8.0


def picture(value: int = 90, dtype: type = np.uint8) -> np.ndarray:
    return np.full((40, 60), value, dtype)


def same_for(watched: InputWatch, shown: np.ndarray, seconds: int) -> float:
    watched.is_frozen(shown, seconds * SECOND)
    return watched.same_for


def test_the_time_since_the_picture_changed_is_measured_by_stamps() -> None:
    watched = watch()
    seconds = [same_for(watched, picture(), stamp) for stamp in (5, 6, 9)]
    assert seconds == [0.0, 1.0, 4.0]
    assert same_for(watched, picture(91), 10) == 0.0
    assert same_for(watched, picture(91), 11) == 1.0


def test_pictures_that_differ_in_one_pixel_are_different() -> None:
    other = picture()
    other[21, 33] += 1
    assert same(picture(), picture())
    assert not same(picture(), other)


@pytest.mark.parametrize("other", [picture()[:-1], picture(dtype=np.float32)])
def test_another_size_or_type_is_another_picture(other: np.ndarray) -> None:
    assert not same(picture(), other)


def test_the_time_of_a_frozen_picture_restarts_when_stamps_go_back() -> None:
    watched = watch()
    seconds = [same_for(watched, picture(), stamp) for stamp in (100, 50, 51)]
    assert seconds == [0.0, 0.0, 1.0]


def test_a_jump_of_the_clock_is_no_time_in_which_the_picture_was_the_same() -> None:
    watched = watch(maximum_gap=3.0)
    stamps = [1, 2, 5, 1_000_000_000, 1_000_000_001, 1_000_000_005, 1_000_000_004]
    seconds = [same_for(watched, picture(), stamp) for stamp in stamps]
    assert seconds == [0.0, 1.0, 4.0, 4.0, 5.0, 5.0, 4.0]


def test_the_watch_counts_no_longer_pause_than_the_filter_bears() -> None:
    watched = watch(maximum_gap=5.0)
    assert not any(watched.is_frozen(picture(), stamp * SECOND) for stamp in (1, 7, 8))
    watched.configure(CameraRuntimeParameters(), 6.0)
    assert watched.is_frozen(picture(), 14 * SECOND)
