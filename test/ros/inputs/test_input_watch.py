from __future__ import annotations

import numpy as np

from cable_tracker.ros.health.diagnostics import FROZEN_INPUT, STALE_INPUT
from cable_tracker.ros.inputs.input_watch import InputWatch

SECOND = 1_000_000_000


def watch(**values: float) -> InputWatch:
    made = InputWatch(100.0)
    made.apply({"input_timeout": 1.0, "frozen_timeout": 2.0, **values})
    return made


def test_silence_is_reported_once_and_ends_with_a_usable_frame() -> None:
    watched = watch()
    assert not watched.falls_silent(101.0)
    assert watched.falls_silent(101.1)
    assert not watched.falls_silent(105.0)
    assert watched.status == STALE_INPUT
    assert watched.note_usable(106.0)
    assert watched.status == ""
    assert not watched.note_usable(106.5)


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


def test_a_timeout_of_zero_never_freezes_and_the_time_is_measured_all_the_same() -> None:
    watched, picture = watch(frozen_timeout=0.0), np.zeros((20, 30), np.uint8)
    assert not any(watched.is_frozen(picture, index * SECOND) for index in range(9))
    assert watched.picture is picture
    assert watched.same_for == 8.0


def test_what_is_not_given_stays() -> None:
    watched = watch()
    watched.apply({"frozen_timeout": 9.0})
    assert watched.timeout == 1.0
