from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.ros.inputs.frozen_input import FrozenInput, same

SECOND = 1_000_000_000


def picture(value: int = 90, dtype: type = np.uint8) -> np.ndarray:
    return np.full((40, 60), value, dtype)


def test_the_time_since_the_picture_changed_is_measured_by_stamps() -> None:
    frozen = FrozenInput()
    seconds = [frozen.take(picture(), stamp * SECOND) for stamp in (5, 6, 9)]
    assert seconds == [0.0, 1.0, 4.0]
    assert frozen.take(picture(91), 10 * SECOND) == 0.0
    assert frozen.take(picture(91), 11 * SECOND) == frozen.seconds == 1.0


def test_one_pixel_is_enough_to_differ() -> None:
    other = picture()
    other[21, 33] += 1
    assert same(picture(), picture())
    assert not same(picture(), other)


@pytest.mark.parametrize("other", [picture()[:-1], picture(dtype=np.float32)])
def test_another_size_or_type_is_another_picture(other: np.ndarray) -> None:
    assert not same(picture(), other)


def test_where_time_goes_back_the_count_begins_anew() -> None:
    frozen = FrozenInput()
    frozen.take(picture(), 100 * SECOND)
    assert frozen.take(picture(), 50 * SECOND) == 0.0
    assert frozen.take(picture(), 51 * SECOND) == 1.0


def test_what_is_forgotten_does_not_count() -> None:
    frozen = FrozenInput()
    frozen.take(picture(), SECOND)
    frozen.forget()
    assert frozen.picture is None
    assert frozen.take(picture(), 9 * SECOND) == 0.0
