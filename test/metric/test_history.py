from copy import deepcopy

import numpy as np
import pytest

from cable_tracker.metric.history import KEPT, History

SECOND = 1_000_000_000


@pytest.fixture
def history():
    history = History()
    for second, value in ((10, 1.0), (11, 3.0), (13, 3.0)):
        history.add(second * SECOND, np.array([value, -value]))
    return history


def test_between_two_measurements_it_interpolates(history):
    reading = history.at(10 * SECOND + SECOND // 4)
    np.testing.assert_allclose(reading.values, [1.5, -1.5])
    assert (reading.age, reading.nearest) == (0.0, 0.25)


def test_after_the_last_its_value_is_held_and_ages(history):
    reading = history.at(15 * SECOND)
    np.testing.assert_allclose(reading.values, [3.0, -3.0])
    assert reading.age == reading.nearest == pytest.approx(2.0)


def test_before_the_first_nothing_is_known(history):
    assert history.at(9 * SECOND) is None
    assert History().at(0) is None


def test_a_value_that_is_not_finite_stays_visible(history):
    history.add(14 * SECOND, np.array([np.inf, 0.0]))
    history.add(15 * SECOND, np.array([np.inf, 0.0]))
    assert not np.isfinite(history.at(14 * SECOND + 5).values).all()


def test_a_clock_that_jumps_back_makes_it_forget(history):
    history.add(2 * SECOND, np.array([7.0, 7.0]))
    assert len(history) == 1
    assert history.at(2 * SECOND - 1) is None


def test_a_message_that_was_overtaken_changes_nothing(history):
    history.add(13 * SECOND - SECOND // 10, np.array([9.0, 9.0]))
    np.testing.assert_allclose(history.at(12 * SECOND).values, [3.0, -3.0])
    assert len(history) == 3


def test_the_measurements_about_a_time(history):
    at = {
        second: [float(v[0]) for v in history.around(int(second * SECOND))]
        for second in (9, 10, 10.5, 15)
    }
    assert at == {9: [1.0], 10: [1.0], 10.5: [1.0, 3.0], 15: [3.0]}


def test_the_same_stamp_counts_once(history):
    history.add(13 * SECOND, np.array([9.0, 9.0]))
    assert len(history) == 3
    np.testing.assert_allclose(history.at(13 * SECOND).values, [3.0, -3.0])


def test_it_does_not_grow_for_ever():
    history = History()
    for stamp in range(3 * KEPT):
        history.add(stamp, np.zeros(1))
    assert len(history) == KEPT


def test_what_was_measured_within_a_time(history):
    found = history.between(10 * SECOND, 13 * SECOND)
    assert [stamp for stamp, _ in found] == [10 * SECOND, 11 * SECOND]


def test_the_same_numbers_again_and_again_are_frozen(history):
    assert not history.is_frozen(2, 11 * SECOND)
    assert history.is_frozen(2, 13 * SECOND)
    assert not history.is_frozen(3, 13 * SECOND)
    assert not history.is_frozen(9, 13 * SECOND)


def test_a_copy_goes_on_by_itself_and_shares_the_measurements(history):
    other = deepcopy(history)
    assert other.last_values is history.last_values
    other.add(14 * SECOND, np.array([9.0, 9.0]))
    assert (len(history), len(other)) == (3, 4)
